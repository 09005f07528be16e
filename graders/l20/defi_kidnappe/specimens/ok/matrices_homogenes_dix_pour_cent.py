class Nuage:
    """Chaque particule est une matrice 3 × 3."""

    def __init__(self, poses):
        poses = np.asarray(poses, dtype=float)
        c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
        self.T = np.zeros((len(poses), 3, 3))
        self.T[:, 0, 0], self.T[:, 0, 1], self.T[:, 0, 2] = c, -s, poses[:, 0]
        self.T[:, 1, 0], self.T[:, 1, 1], self.T[:, 1, 2] = s, c, poses[:, 1]
        self.T[:, 2, 2] = 1

    def __matmul__(self, autre):
        self.T = self.T @ autre.T
        return self

    @property
    def poses(self):
        return np.stack([self.T[:, 0, 2], self.T[:, 1, 2], np.arctan2(self.T[:, 1, 0], self.T[:, 0, 0])], axis=-1)


def initialiser(n):
    candidats = np.column_stack([rng.uniform(0, W, 40 * n + 200), rng.uniform(0, H, 40 * n + 200)])
    bons = candidats[libres[candidats[:, 1].astype(int), candidats[:, 0].astype(int)]][:n]
    return np.column_stack([bons, rng.uniform(-np.pi, np.pi, n)])


def pas_mcl(particules, poids, u, scan):
    n = len(particules)
    nuage = (Nuage(particules) @ Nuage(np.tile(u, (n, 1)) + rng.normal(size=(n, 3)) * 0.07)).poses
    d2 = np.square(lidar_lot(nuage, 36)[:, ::3] - scan[::3])
    w = poids * np.prod(np.exp(-d2 / 0.5) + 0.02, axis=1)
    w = w / np.sum(w)
    if np.sum(w**2) > 2 / n:
        cumul = np.cumsum(w)
        cumul[-1] = 1
        nuage = nuage[np.searchsorted(cumul, (rng.random() + np.arange(n)) / n)]
        w = np.repeat(1 / n, n)
    return [nuage, w]


def estimer(particules, poids):
    M = np.tensordot(poids, Nuage(particules).T, axes=1)
    return [M[0, 2], M[1, 2], np.arctan2(M[1, 0], M[0, 0])]

_pas_sans_injection = pas_mcl


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    n = len(w)
    combien = n // 10
    garde = np.argsort(w)[combien:]
    p = np.concatenate([np.asarray(p)[garde], np.asarray(initialiser(combien))])
    w = np.concatenate([np.asarray(w)[garde], np.full(combien, 1.0 / n)])
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
