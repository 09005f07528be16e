"""Nodes that compare themselves and hold their parent."""

from heapq import heappush, heappop
from typing import NamedTuple, Optional


class Noeud(NamedTuple):
    f: float
    g: float
    ligne: int
    colonne: int
    parent: Optional[tuple]


def gonfler(grille, rayon, resolution):
    def permise(i, j):
        if grille[i, j] != 0:
            return False
        k = int(rayon / resolution) + 1
        for a in range(max(0, i - k), min(grille.shape[0], i + k + 1)):
            for b in range(max(0, j - k), min(grille.shape[1], j + k + 1)):
                if grille[a, b] == 100 and ((a - i) ** 2 + (b - j) ** 2) * resolution**2 <= rayon**2:
                    return False
        return True

    return np.array([[permise(i, j) for j in range(grille.shape[1])] for i in range(grille.shape[0])])


def cout(chemin, couts):
    if not chemin:
        return 0.0
    total, (i, j) = 0.0, chemin[0]
    for y, x in chemin[1:]:
        total += (2.0 if (y - i) ** 2 + (x - j) ** 2 == 2 else 1.0) ** 0.5 * (1 + couts[i, j] / 2 + couts[y, x] / 2)
        i, j = y, x
    return total


def planifier(permises, couts, depart, but):
    if not permises[depart[0], depart[1]]:
        return []
    if not permises[but[0], but[1]]:
        return []
    tas = []
    heappush(tas, Noeud(0.0, 0.0, depart[0], depart[1], None))
    vus = {}
    while tas:
        noeud = heappop(tas)
        case = noeud.ligne, noeud.colonne
        if vus.get(case, float("inf")) <= noeud.g:
            continue
        vus[case] = noeud.g
        if case == (but[0], but[1]):
            chemin = []
            while noeud is not None:
                chemin.insert(0, [noeud.ligne, noeud.colonne])
                noeud = noeud.parent
            return chemin
        for di in range(-1, 2):
            for dj in range(-1, 2):
                i, j = case[0] + di, case[1] + dj
                if min(i, j) < 0 or i >= permises.shape[0] or j >= permises.shape[1] or (di == 0 and dj == 0):
                    continue
                if not permises[i, j]:
                    continue
                if di != 0 and dj != 0 and (not permises[i, case[1]] or not permises[case[0], j]):
                    continue
                g = noeud.g + cout([case, (i, j)], couts)
                a, b = abs(i - but[0]), abs(j - but[1])
                heappush(tas, Noeud(g + (a + b) - (2 - 2**0.5) * min(a, b), g, i, j, noeud))
    return []
