import heapq

import numpy as np


def gonfler(grille, rayon, resolution):
    permises = grille == 0
    lignes, colonnes = np.indices(grille.shape)
    for i, j in np.argwhere(grille == 100):
        permises &= np.hypot(lignes - i, colonnes - j) * resolution > rayon
    return permises


def prix(a, b, couts):
    return np.hypot(a[0] - b[0], a[1] - b[1]) * (1 + (couts[a] + couts[b]) / 2)


def cout(chemin, couts):
    cases = [tuple(case) for case in chemin]
    return sum(prix(a, b, couts) for a, b in zip(cases, cases[1:]))


def planifier(permises, couts, depart, but):
    if not permises[depart] or not permises[but]:
        return []
    reste = lambda case: abs(case[0] - but[0]) + abs(case[1] - but[1])
    ouvertes, venue = [(reste(depart), 0.0, depart, None)], {}
    while ouvertes:
        _, g, case, avant = heapq.heappop(ouvertes)
        if case in venue:
            continue
        venue[case] = avant
        if case == but:
            chemin = []
            while case is not None:
                chemin.append(case)
                case = venue[case]
            return chemin[::-1]
        i, j = case
        for a in (i - 1, i, i + 1):
            for b in (j - 1, j, j + 1):
                dans = 0 <= a < permises.shape[0] and 0 <= b < permises.shape[1]
                if dans and (a, b) not in venue and permises[a, b] and permises[i, b] and permises[a, j]:
                    plus_loin = g + prix(case, (a, b), couts)
                    heapq.heappush(ouvertes, (plus_loin + reste((a, b)), plus_loin, (a, b), case))
    return []
