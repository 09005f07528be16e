"""A class of poses with operators."""
from math import atan2, cos, sin, sqrt


class Pose:
    def __init__(self, x, y, t):
        self.x, self.y, self.t = x, y, t

    def __neg__(self):
        c, s = cos(self.t), sin(self.t)
        return Pose(-c * self.x - s * self.y, s * self.x - c * self.y, -self.t)

    def __add__(self, b):
        c, s = cos(self.t), sin(self.t)
        return Pose(self.x + c * b.x - s * b.y, self.y + s * b.x + c * b.y, self.t + b.t)

    @property
    def carre(self):
        return self.x**2 + self.y**2


def ate(estimees, verite):
    n = len(verite)
    P = estimees[:, :2] - estimees[:, :2].sum(0) / n
    Q = verite[:, :2] - verite[:, :2].sum(0) / n
    H = P.T @ Q
    tour = Pose(0, 0, atan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1]))
    return sqrt(sum((tour + Pose(*p, 0) + Pose(0, 0, -tour.t) + Pose(*-q, 0)).carre for p, q in zip(P, Q)) / n)


def rpe(estimees, verite, delta):
    est, vrai = [Pose(*p) for p in estimees], [Pose(*p) for p in verite]
    total = nombre = 0
    for a, b, c, d in zip(est, est[delta:], vrai, vrai[delta:]):
        total += (-(-c + d) + (-a + b)).carre
        nombre += 1
    return sqrt(total / nombre)
