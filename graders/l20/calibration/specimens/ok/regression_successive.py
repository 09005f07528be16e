"""Turns per metre regressed step by step: recursive least squares from the first steps on, then exact sums."""
from functools import reduce


def avance(pas):
    return np.array(list(map(lambda p: np.dot(p[:2], [np.cos(p[2] / 2), np.sin(p[2] / 2)]), pas)))


def etalonner(pas, vrais):
    def ajouter(etat, ligne):
        M, m = etat
        theta, d, cible = ligne
        j = np.array([theta, d])
        return M + np.outer(j, j), m + cible * j

    d = avance(pas)
    M, m = reduce(ajouter, zip(pas[:, 2], d, vrais[:, 2]), (np.zeros((2, 2)), np.zeros(2)))
    valeurs, axes = np.linalg.eigh(M)
    beta, alpha = axes @ ((axes.T @ m) / valeurs)
    haut, bas = reduce(lambda s, p: (s[0] + p[0] * p[1], s[1] + p[0] ** 2), zip(d, avance(vrais)), (0.0, 0.0))
    return haut / bas, beta, alpha


def corriger(pas, gamma, beta, alpha):
    def une(p, d):
        neuf = beta * p[2] + alpha * d
        c, s = np.cos((neuf - p[2]) / 2), np.sin((neuf - p[2]) / 2)
        return np.array([gamma * (c * p[0] - s * p[1]), gamma * (s * p[0] + c * p[1]), neuf])

    return np.stack([une(p, d) for p, d in zip(pas, avance(pas))])
