from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Carte:
    grille: np.ndarray

    def bloque(self, point) -> bool:
        i, j = np.floor(point).astype(int)
        h, w = self.grille.shape
        return not (i in range(w) and j in range(h) and bool(self.grille[j, i]))


@dataclass
class Rayon:
    origine: np.ndarray
    vecteur: np.ndarray

    def au_bout_de(self, t: float):
        return self.origine + t * self.vecteur


def lancer_rayon(libres, x, y, angle, portee_max):
    carte = Carte(libres)
    rayon = Rayon(np.array([x, y]), np.array([np.cos(angle), np.sin(angle)]))
    pas = 0.05
    n = 0
    while n * pas < portee_max and not carte.bloque(rayon.au_bout_de(n * pas)):
        n += 1
    return min(n * pas, portee_max)
