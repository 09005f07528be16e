"""Closures over the grid; h halved on purpose: slower, and just as right."""

import heapq


def gonfler(grille, rayon, resolution):
    permises = (grille == 0).copy()
    lignes, colonnes = np.where(grille == 100)
    for ligne, colonne in zip(lignes, colonnes):
        dy = (np.arange(grille.shape[0]) - ligne) * resolution
        dx = (np.arange(grille.shape[1]) - colonne) * resolution
        permises &= np.add.outer(dy**2, dx**2) > rayon * rayon
    return permises.astype(int)


def compteur(couts):
    def pas(a, b):
        return np.sqrt(abs(a[0] - b[0]) + abs(a[1] - b[1])) * np.mean([1 + couts[a[0]][a[1]], 1 + couts[b[0]][b[1]]])

    return pas


def cout(chemin, couts):
    pas = compteur(couts)
    return np.sum([pas(chemin[k], chemin[k + 1]) for k in range(len(chemin) - 1)])


def planifier(permises, couts, depart, but):
    pas = compteur(couts)

    def ouverte(i, j):
        try:
            return i >= 0 and j >= 0 and permises[i, j]
        except IndexError:
            return False

    def suivantes(case):
        i, j = case
        for y, x in [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)]:
            if ouverte(y, x):
                yield y, x
        for y, x in [(i + 1, j + 1), (i - 1, j + 1), (i + 1, j - 1), (i - 1, j - 1)]:
            if ouverte(y, x) and ouverte(i, x) and ouverte(y, j):
                yield y, x

    if not (ouverte(*depart) and ouverte(*but)):
        return []
    prix = {depart: 0.0}
    chemins = {depart: [depart]}
    tas = [(0.0, depart)]
    while tas:
        case = heapq.heappop(tas)[1]
        if case == but:
            return chemins[case]
        for v in suivantes(case):
            g = prix[case] + pas(case, v)
            if v not in prix or g < prix[v]:
                prix[v] = g
                chemins[v] = chemins[case] + [v]
                heapq.heappush(tas, (g + 0.5 * np.hypot(v[0] - but[0], v[1] - but[1]), v))
    return []
