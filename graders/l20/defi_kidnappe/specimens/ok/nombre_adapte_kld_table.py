# KLD : le nombre de particules s'adapte au nuage.
def initialiser(n):
    c = np.argwhere(libres)[rng.integers(0, libres.sum(), n)]
    return np.column_stack([c[:, 1] + rng.random(n), c[:, 0] + rng.random(n), rng.uniform(-np.pi, np.pi, n)])


def assez(p):
    boites = {(int(2 * x), int(2 * y), int(6 * t)) for x, y, t in p}
    k = len(boites)
    return 200 if k < 2 else int(min(500, max(200, (k - 1) / (2 * 0.02) * (1 - 2 / (9 * (k - 1)) + np.sqrt(2 / (9 * (k - 1))) * 2.33) ** 3)))


def pas_mcl(particules, poids, u, scan):
    n = len(particules)
    x, y, t = particules.T
    dx, dy, dt = u[:, None] + np.array([[0.08], [0.08], [0.05]]) * rng.standard_normal((3, n))
    p = np.array([x + dx * np.cos(t) - dy * np.sin(t), y + dx * np.sin(t) + dy * np.cos(t), t + dt]).T
    l = -np.minimum(((lidar_lot(p, 12) - scan[::3]) / 0.35) ** 2 / 2, 5).sum(axis=1) + np.log(poids)
    w = np.exp(l - l.max())
    w /= w.sum()
    if 1 / np.sum(w**2) < n / 2:
        tirage = rng.choice(n, 500, p=w)
        p = p[tirage][: assez(p[tirage])]
        w = np.full(len(p), 1 / len(p))
    return p, w


def estimer(particules, poids):
    t = np.arctan2((poids * np.sin(particules[:, 2])).sum(), (poids * np.cos(particules[:, 2])).sum())
    return np.append((poids[:, None] * particules[:, :2]).sum(axis=0), t)

_pas_sans_injection = pas_mcl


# Une table des scans vus de partout : elle dit où le robot pourrait être.
TABLE = np.array([(x + 0.5, y + 0.5, t) for y, x in np.argwhere(libres) for t in np.arange(-np.pi, np.pi, np.pi / 18)])
VUS = lidar_lot(TABLE, 12)


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    n = len(p)
    l = -np.minimum(np.abs(VUS - scan[::3]), 1.5).sum(axis=1)
    l = np.exp(2 * (l - l.max()))
    places = rng.integers(0, n, n // 16)
    p[places] = TABLE[rng.choice(len(TABLE), len(places), p=l / l.sum())] + rng.uniform(-0.5, 0.5, (len(places), 3)) * (1, 1, 0.17)
    w[places] = 1.0 / n
    return p, w / w.sum()
