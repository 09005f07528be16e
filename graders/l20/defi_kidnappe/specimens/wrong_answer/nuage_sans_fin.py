"""Sixty particles more at each step: over 5000 before the end of a run."""

import numpy as np

PART = 60          # poses semées à chaque pas


def initialiser(n):
    yx = np.argwhere(libres)[rng.integers(0, libres.sum(), n)]
    p = np.zeros((n, 3))
    p[:, 0] = yx[:, 1] + rng.random(n)
    p[:, 1] = yx[:, 0] + rng.random(n)
    p[:, 2] = rng.uniform(-np.pi, np.pi, n)
    return p


def bouger(p, u):
    b = rng.normal(0, 1, p.shape) * np.array([0.06, 0.06, 0.04]) + u
    c, s = np.cos(p[:, 2]), np.sin(p[:, 2])
    return p + np.stack([b[:, 0] * c - b[:, 1] * s, b[:, 0] * s + b[:, 1] * c, b[:, 2]], axis=1)


def pas_mcl(particules, poids, u, scan):
    p = bouger(particules, u)
    # injecter avant de peser : le scan dira ce qu'elles valent
    p = np.vstack([p, initialiser(PART)])
    w = np.concatenate([poids, np.full(PART, 1 / len(poids))])
    logs = -np.sum((lidar_lot(p, 36) - scan) ** 2, axis=1) / (2 * 0.5 ** 2)
    w = w * np.exp(logs - logs.max())
    w = w / w.sum()
    n = len(p)
    if 1 / (w @ w) < n / 2:
        bords = np.cumsum(w)
        bords[-1] = 1.0
        p = p[np.searchsorted(bords, (np.arange(n) + rng.random()) / n)]
        w = np.ones(n) / n
    return p, w


def estimer(particules, poids):
    # tour à tour, la moyenne de ce qui est près de la moyenne
    i = np.argmax(poids)
    centre = np.median(particules[:, :2], axis=0) if poids.max() < 2 / len(poids) else particules[i, :2]
    for _ in range(5):
        d2 = np.sum((particules[:, :2] - centre) ** 2, axis=1)
        k = poids * np.exp(-d2 / 2)
        centre = k @ particules[:, :2] / k.sum()
    k = k / k.sum()
    return np.array([centre[0], centre[1], np.angle(k @ np.exp(1j * particules[:, 2]))])
