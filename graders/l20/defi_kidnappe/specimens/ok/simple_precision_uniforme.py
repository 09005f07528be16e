# Tout en float32 ; les poids sont renormalisés à la fin.
f = np.float32


def initialiser(n):
    c = np.argwhere(libres)[rng.integers(0, libres.sum(), n)].astype(f)
    a = np.empty((n, 3), f)
    a[:, 0] = c[:, 1] + f(0.999) * rng.random(n, dtype=f)
    a[:, 1] = c[:, 0] + f(0.999) * rng.random(n, dtype=f)
    a[:, 2] = f(2 * np.pi) * rng.random(n, dtype=f) - f(np.pi)
    return a


def pas_mcl(particules, poids, u, scan):
    p, w = particules.astype(f), poids.astype(f)
    n = len(p)
    d = u.astype(f) + f(0.08) * rng.standard_normal((n, 3), dtype=f) * np.array([1, 1, 0.6], f)
    c, s = np.cos(p[:, 2]), np.sin(p[:, 2])
    p = np.stack([p[:, 0] + c * d[:, 0] - s * d[:, 1], p[:, 1] + s * d[:, 0] + c * d[:, 1], p[:, 2] + d[:, 2]], 1)
    e = np.minimum(np.abs(lidar_lot(p, 12).astype(f) - scan[::3].astype(f)), f(1.5))
    l = -(e * e).sum(1) / f(2 * 0.3**2)
    w = w * np.exp(l - l.max())
    w = w / w.sum()
    if 1 / (w * w).sum() < n / 2:
        p = p[np.searchsorted(np.cumsum(w)[:-1], (np.arange(n, dtype=f) + rng.random(dtype=f)) / n)]
        w = np.full(n, 1 / n, f)
    return p, w


def estimer(particules, poids):
    w = poids.astype(f)[:, None]
    x, y, c, s = (w * np.column_stack([particules[:, :2], np.cos(particules[:, 2]), np.sin(particules[:, 2])])).sum(0)
    return np.array([x, y, np.arctan2(s, c)], f)

_pas_sans_injection = pas_mcl


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    # une particule sur vingt, n'importe où ; elles prennent le poids moyen
    k = rng.random(len(p)) < 0.05
    p[k] = np.asarray(initialiser(int(k.sum()))).reshape(-1, 3)
    w[k] = 1 / len(p)
    return p, w / w.sum()
