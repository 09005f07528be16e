"""A class that holds the grid; Dijkstra, cells as single numbers."""

import heapq
import math
from dataclasses import dataclass

from scipy import ndimage


def gonfler(grille, rayon, resolution):
    murs = np.asarray(grille) == 100
    return np.logical_and(np.asarray(grille) == 0, ndimage.distance_transform_edt(~murs, sampling=resolution) > rayon)


def cout(chemin, couts):
    somme = []
    for k in range(1, len(chemin)):
        (i, j), (y, x) = chemin[k - 1], chemin[k]
        somme.append(math.hypot(y - i, x - j) * (1 + 0.5 * (couts[i, j] + couts[y, x])))
    return math.fsum(somme)


@dataclass
class Carte:
    permises: np.ndarray
    couts: np.ndarray

    def numero(self, case):
        return case[0] * self.permises.shape[1] + case[1]

    def case(self, numero):
        return divmod(numero, self.permises.shape[1])

    def ouverte(self, i, j):
        h, w = self.permises.shape
        return 0 <= i < h and 0 <= j < w and bool(self.permises[i, j])

    def pas(self, numero):
        i, j = self.case(numero)
        for di in (-1, 0, 1):
            for dj in (-1, 0, 1):
                if (di, dj) == (0, 0) or not self.ouverte(i + di, j + dj):
                    continue
                if di and dj and not (self.ouverte(i + di, j) and self.ouverte(i, j + dj)):
                    continue
                moyenne = (self.couts[i, j] + self.couts[i + di, j + dj]) / 2
                yield self.numero((i + di, j + dj)), math.hypot(di, dj) * (1 + moyenne)

    def dijkstra(self, depart, but):
        d, b = self.numero(depart), self.numero(but)
        prix, venu, fait, attente = {d: 0.0}, {}, set(), [(0.0, d)]
        while attente:
            p, n = heapq.heappop(attente)
            if n in fait:
                continue
            fait.add(n)
            for m, c in self.pas(n):
                if p + c < prix.get(m, math.inf):
                    prix[m], venu[m] = p + c, n
                    heapq.heappush(attente, (p + c, m))
        if b not in fait:
            return []
        suite = [b]
        while suite[-1] != d:
            suite.append(venu[suite[-1]])
        return [self.case(n) for n in suite[::-1]]


def planifier(permises, couts, depart, but):
    carte = Carte(permises, couts)
    if not carte.ouverte(*depart) or not carte.ouverte(*but):
        return []
    return carte.dijkstra(depart, but)
