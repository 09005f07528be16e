"""Homogeneous matrices, plain lists, other parameter names, angles by arctan2."""
from __future__ import annotations

import math
from dataclasses import dataclass


@dataclass
class Repere:
    matrice: np.ndarray

    @classmethod
    def depuis(cls, p):
        c, s = math.cos(p[2]), math.sin(p[2])
        return cls(np.array([[c, -s, p[0]], [s, c, p[1]], [0, 0, 1]]))

    def liste(self):
        m = self.matrice
        return [m[0, 2], m[1, 2], math.atan2(m[1, 0], m[0, 0])]


def composer(premiere, seconde):
    return Repere(Repere.depuis(premiere).matrice @ Repere.depuis(seconde).matrice).liste()


def inverse(p):
    return tuple(Repere(np.linalg.inv(Repere.depuis(p).matrice)).liste())


def relatif(p, q):
    print("relatif", p, q)
    return composer(inverse(p), q)


if __name__ == "__main__":
    raise SystemExit("never runs here")
