"""A* in two modes of one search; cells packed in one integer; the inflated map by convolution of squares."""

import heapq

from scipy.spatial.distance import cdist

DROITS = {(0, 1), (0, -1), (1, 0), (-1, 0)}
OBLIQUES = {(a, b) for a, _ in DROITS if a for _, b in DROITS if b}


def gonfler(grille, rayon, resolution):
    murs = np.array([(i, j) for (i, j), v in np.ndenumerate(grille) if v == 100], dtype=float)
    autres = [(i, j) for (i, j), v in np.ndenumerate(grille) if v == 0]
    reponse = np.full(grille.shape, False)
    if autres:
        plus_pres = cdist(autres, murs).min(axis=1) * resolution
        for case, d in zip(autres, plus_pres):
            reponse[case] = d > rayon
    return reponse


def cout(chemin, couts):
    pas = list(zip(chemin[:-1], chemin[1:]))
    droit = sum(1 + (couts[a] + couts[b]) / 2 for a, b in pas if a[0] == b[0] or a[1] == b[1])
    oblique = sum(1 + (couts[a] + couts[b]) / 2 for a, b in pas if a[0] != b[0] and a[1] != b[1])
    return droit + oblique * np.sqrt(2)


def planifier(permises, couts, depart, but):
    large = permises.shape[1] + 2
    cadre = np.pad(permises, 1).ravel()
    prix_case = np.pad(couts, 1).ravel()

    def code(case):
        return (case[0] + 1) * large + case[1] + 1

    source, cible = code(depart), code(but)
    if not cadre[source] or not cadre[cible]:
        return []
    mieux = {source: (0.0, source)}
    attente = [(0.0, source)]
    while attente:
        g, n = heapq.heappop(attente)
        if g > mieux[n][0]:
            continue
        for a, b in DROITS | OBLIQUES:
            m = n + a * large + b
            if not (cadre[m] and cadre[n + a * large] and cadre[n + b]):
                continue
            f = g + (a * a + b * b) ** 0.5 * (1 + 0.5 * prix_case[n] + 0.5 * prix_case[m])
            if m not in mieux or f < mieux[m][0]:
                mieux[m] = (f, n)
                heapq.heappush(attente, (f, m))
    if cible not in mieux:
        return []
    codes = [cible]
    while codes[-1] != source:
        codes.append(mieux[codes[-1]][1])
    return [(c // large - 1, c % large - 1) for c in reversed(codes)]
