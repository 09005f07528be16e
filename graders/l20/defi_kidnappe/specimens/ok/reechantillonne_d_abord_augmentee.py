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

_pas_sans_injection = pas_mcl


lente = rapide = None


def pas_mcl(particules, poids, u, scan):
    global lente, rapide
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    n = len(p)
    accord = float(w @ np.exp(-np.minimum((lidar_lot(p, 12) - scan[::3]) ** 2, 4) / 0.5).mean(axis=1))
    lente = accord if lente is None else lente + 0.01 * (accord - lente)
    rapide = accord if rapide is None else rapide + 0.4 * (accord - rapide)
    part = max(0.03, 1 - rapide / lente)
    k = rng.random(n) < part
    p[k] = np.asarray(initialiser(int(k.sum()))).reshape(-1, 3)
    w[k] = 1.0 / n
    return p, w / w.sum()


def estimer(particules, poids):
    p, w = np.asarray(particules, dtype=float), np.asarray(poids, dtype=float)
    boites = {}
    for (x, y, t), v in zip(p, w):
        b = (int(x), int(y), int(np.floor(t / (np.pi / 4))) % 8)
        boites[b] = boites.get(b, 0.0) + v
    i, j, _ = max(boites, key=boites.get)
    pres = np.hypot(p[:, 0] - i - 0.5, p[:, 1] - j - 0.5) < 1.2
    c = w[pres] @ np.exp(1j * p[pres, 2])
    return np.array([*(w[pres] @ p[pres, :2] / w[pres].sum()), np.angle(c)])
