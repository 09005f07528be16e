"""Blocks in dictionaries, generators of contributions, the inverse of H."""
from collections import defaultdict
from itertools import product


def erreur(depart, arrivee, mesure):
    c, s = np.cos(depart[2]), np.sin(depart[2])
    ex = c * (arrivee[0] - depart[0]) + s * (arrivee[1] - depart[1]) - mesure[0]
    ey = c * (arrivee[1] - depart[1]) - s * (arrivee[0] - depart[0]) - mesure[1]
    et = arrivee[2] - depart[2] - mesure[2]
    while et > np.pi:
        et -= 2 * np.pi
    while et < -np.pi:
        et += 2 * np.pi
    return [ex, ey, et]


def sensibilites(x, i, j):
    c, s = np.cos(x[i][2]), np.sin(x[i][2])
    dx, dy, _ = np.subtract(x[j], x[i])
    yield i, np.array([[-c, -s, c * dy - s * dx], [s, -c, -c * dx - s * dy], [0.0, 0.0, -1.0]])
    yield j, np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])


def contributions(x, aretes):
    for i, j, z, omega in aretes:
        e = np.array(erreur(x[i], x[j], z))
        cotes = dict(sensibilites(x, i, j))
        for a, b in product(cotes, repeat=2):
            yield (a, b), cotes[a].T @ omega @ cotes[b]
        for a in cotes:
            yield (a,), cotes[a].T @ omega @ e


def gauss_newton(poses, aretes, n_iter=10):
    x = [list(map(float, p)) for p in poses]
    n = len(x)
    for _ in range(n_iter):
        sommes = defaultdict(lambda: 0.0)
        for cle, bloc in contributions(x, aretes):
            sommes[cle] = sommes[cle] + bloc
        vide = np.zeros((3, 3))
        H = np.concatenate([np.concatenate([sommes.get((a, b), vide) for b in range(1, n)], axis=1) for a in range(1, n)])
        b = np.concatenate([sommes.get((a,), np.zeros(3)) for a in range(1, n)])
        pas = -np.linalg.inv(H) @ b
        for k in range(1, n):
            for q in range(3):
                x[k][q] += pas[3 * (k - 1) + q]
            x[k][2] = float(np.angle(np.exp(1j * x[k][2])))
    return x
