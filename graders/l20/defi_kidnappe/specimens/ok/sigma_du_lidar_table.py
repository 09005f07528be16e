# La vraie gaussienne du lidar, sigma = 0,1, sans borne : le maximum retranché suffit.
def initialiser(n):
    libres_yx = list(zip(*np.where(libres)))
    choix = [libres_yx[k] for k in rng.integers(0, len(libres_yx), n)]
    return np.array([(x + rng.uniform(0, 1), y + rng.uniform(0, 1), rng.uniform(-3.14159, 3.14159)) for y, x in choix])


def pas_mcl(particules, poids, u, scan):
    n = particules.shape[0]
    secousses = rng.multivariate_normal([0, 0, 0], np.diag([0.05, 0.05, 0.03]) ** 2, n)
    depl = u + secousses
    cs, sn = np.cos(particules[:, 2]), np.sin(particules[:, 2])
    q = np.zeros_like(particules)
    q[:, 0] = particules[:, 0] + cs * depl[:, 0] - sn * depl[:, 1]
    q[:, 1] = particules[:, 1] + sn * depl[:, 0] + cs * depl[:, 1]
    q[:, 2] = (particules[:, 2] + depl[:, 2] + np.pi) % (2 * np.pi) - np.pi
    log_w = np.log(poids + 1e-300) - ((scan - lidar_lot(q, 36)) ** 2).sum(1) / (2 * 0.1**2)
    log_w -= log_w.max()
    w = np.exp(log_w)
    w /= w.sum()
    if 1.0 / np.sum(w**2) < n / 2:
        u0 = rng.uniform(0, 1 / n)
        idx, c, i = [], w[0], 0
        for m in range(n):
            while u0 + m / n > c and i < n - 1:
                i += 1
                c += w[i]
            idx.append(i)
        q = q[idx]
        w = np.ones(n) / n
    return q, w


def estimer(particules, poids):
    return np.array([
        np.sum(poids * particules[:, 0]),
        np.sum(poids * particules[:, 1]),
        np.arctan2(np.sum(poids * np.sin(particules[:, 2])), np.sum(poids * np.cos(particules[:, 2]))),
    ])

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
