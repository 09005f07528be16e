"""Two equations, one unknown: x = m and x = z, each divided by its standard deviation."""
import math


def predire(m, v, u, q):
    return math.fsum((m, u)), math.fsum((v, q))


def corriger(m, v, z, r):
    poids = np.array([1 / math.sqrt(v), 1 / math.sqrt(r)])
    A = poids[:, None]
    b = poids * np.array([m, z])
    normale = A.T @ A
    return np.linalg.solve(normale, A.T @ b)[0], np.linalg.inv(normale)[0, 0]
