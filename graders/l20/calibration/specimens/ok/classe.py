"""A class for a step."""
from dataclasses import dataclass
from math import cos, sin


@dataclass
class Pas:
    x: float
    y: float
    virage: float

    @property
    def avance(self):
        return self.x * cos(self.virage / 2) + self.y * sin(self.virage / 2)

    def corrige(self, gamma, beta, alpha):
        nouveau = beta * self.virage + alpha * self.avance
        c, s = cos((nouveau - self.virage) / 2), sin((nouveau - self.virage) / 2)
        return Pas(gamma * (c * self.x - s * self.y), gamma * (s * self.x + c * self.y), nouveau)

    def en_liste(self):
        return [self.x, self.y, self.virage]


def avance(pas):
    return [Pas(*ligne).avance for ligne in pas]


def etalonner(pas, vrais):
    comptes, reels = [Pas(*p) for p in pas], [Pas(*p) for p in vrais]
    A = np.array([[p.virage, p.avance] for p in comptes])
    (beta, alpha), *_ = np.linalg.lstsq(A, np.array([p.virage for p in reels]), rcond=None)
    haut = sum(p.avance * q.avance for p, q in zip(comptes, reels))
    return [haut / sum(p.avance**2 for p in comptes), beta, alpha]


def corriger(pas, gamma, beta, alpha):
    return [Pas(*ligne).corrige(gamma, beta, alpha).en_liste() for ligne in pas]
