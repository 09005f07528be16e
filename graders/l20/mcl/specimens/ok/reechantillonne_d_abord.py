# Le tirage se fait au début du pas suivant : les poids rendus sont ceux de la dernière mesure.
from functools import reduce

compose = lambda p, q: (p[0] + q[0] * np.cos(p[2]) - q[1] * np.sin(p[2]), p[1] + q[0] * np.sin(p[2]) + q[1] * np.cos(p[2]), p[2] + q[2])
neff = lambda w: 1 / np.square(w).sum()


def initialiser(n):
    def une(_):
        y, x = CASES[rng.integers(len(CASES))]
        return x + rng.random(), y + rng.random(), rng.uniform(-np.pi, np.pi)
    CASES = np.argwhere(libres)
    return tuple(map(une, range(n)))


def pas_mcl(nuage, w, u, z):
    nuage, w = np.array(nuage, float), np.array(w, float)
    n = len(nuage)
    if neff(w) < n / 2:
        nuage, w = nuage[rng.choice(n, n, p=w / w.sum())], np.ones(n) / n
    bruits = 0.07 * rng.standard_normal((3, n))
    x, y, t = reduce(compose, [tuple(nuage.T), tuple(u[:, None] + bruits)])
    nuage = np.array([x, y, t]).T
    lu = lidar_lot(nuage, 12)
    cout = np.sum(np.sqrt(1 + ((lu - z[::3]) / 0.3) ** 2) - 1, axis=1)
    w = w * np.exp(cout.min() - cout)
    return tuple(map(tuple, nuage.tolist())), tuple((w / w.sum()).tolist())


def estimer(nuage, w):
    x, y, t = zip(*nuage)
    return np.dot(w, x), np.dot(w, y), np.angle(np.dot(w, np.exp(1j * np.array(t))))
