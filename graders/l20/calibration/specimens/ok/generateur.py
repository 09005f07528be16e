"""Generators, and a named tuple of constants."""
from collections import namedtuple

Constantes = namedtuple("Constantes", "gamma beta alpha")


def cordes(pas):
    for x, y, theta in pas:
        yield x * np.cos(theta / 2) + y * np.sin(theta / 2)


def avance(pas):
    return np.fromiter(cordes(pas), dtype=float, count=len(pas))


def etalonner(pas, vrais):
    d = avance(pas)
    U, S, Vt = np.linalg.svd(np.column_stack([pas[:, 2], d]), full_matrices=False)
    beta, alpha = Vt.T @ (U.T @ vrais[:, 2] / S)
    return Constantes(gamma=np.average(avance(vrais) / np.where(d == 0, 1, d), weights=d**2), beta=beta, alpha=alpha)


def corriges(pas, k):
    for ligne, d in zip(pas, cordes(pas)):
        virage = k.beta * ligne[2] + k.alpha * d
        a = (virage - ligne[2]) / 2
        yield from (
            k.gamma * (ligne[0] * np.cos(a) - ligne[1] * np.sin(a)),
            k.gamma * (ligne[0] * np.sin(a) + ligne[1] * np.cos(a)),
            virage,
        )


def corriger(pas, gamma, beta, alpha):
    return np.fromiter(corriges(pas, Constantes(gamma, beta, alpha)), dtype=float).reshape(-1, 3)
