"""Small generators, a chain of maps, Chebyshev's distance."""

import heapq
from functools import partial

VOISINS = ((-1, -1), (-1, 0), (-1, 1), (0, -1), (0, 1), (1, -1), (1, 0), (1, 1))


def disque(rayon):
    n = int(rayon)
    for a in range(-n, n + 1):
        yield from ((a, b) for b in range(-n, n + 1) if a * a + b * b <= rayon * rayon)


def gonfler(grille, rayon, resolution):
    interdites = {
        (i + a, j + b) for i, j in zip(*map(np.ndarray.tolist, np.where(grille == 100)))
        for a, b in disque(rayon / resolution)
    }
    libre = grille == 0
    for i, j in interdites:
        if 0 <= i < len(grille) and 0 <= j < len(grille[0]):
            libre[i, j] = False
    return libre


def un_pas(couts, a, b):
    diagonale = (a[0] - b[0]) * (a[1] - b[1]) != 0
    return 2 ** (diagonale / 2) * (2 + couts[a] + couts[b]) / 2


def cout(chemin, couts):
    return sum(map(partial(un_pas, couts), map(tuple, chemin), map(tuple, chemin[1:])))


def voisins(permises, case):
    def dedans(i, j):
        return i in range(permises.shape[0]) and j in range(permises.shape[1]) and permises[i, j]

    for a, b in VOISINS:
        trois = (case[0] + a, case[1] + b), (case[0] + a, case[1]), (case[0], case[1] + b)
        if all(dedans(*c) for c in trois):
            yield trois[0]


def planifier(permises, couts, depart, but):
    def h(case):
        return max(abs(case[0] - but[0]), abs(case[1] - but[1]))

    if not permises[depart] & permises[but]:
        return []
    g, d_ou = {depart: 0}, {}
    file = [(h(depart), depart)]
    while file:
        f, case = heapq.heappop(file)
        if case == but:
            chemin = (case,)
            while chemin[0] in d_ou:
                chemin = (d_ou[chemin[0]], *chemin)
            return chemin
        if f > g[case] + h(case) + 1e-12:
            continue
        for v in voisins(permises, case):
            prix = g[case] + un_pas(couts, case, v)
            if prix < g.setdefault(v, np.inf):
                g[v], d_ou[v] = prix, case
                heapq.heappush(file, (prix + h(v), v))
    return []
