def initialiser(n):
    nuage = np.empty((n, 3))
    for i in range(n):
        while True:
            x, y = rng.uniform(0, W), rng.uniform(0, H)
            if libres[int(y), int(x)]:
                break
        nuage[i] = x, y, rng.uniform(0, 2 * np.pi)
    return nuage


def pas_mcl(p, w, u, z):
    n = len(p)
    c, s = np.cos(p[:, 2]), np.sin(p[:, 2])
    q = p.copy()
    a = u[0] + 0.1 * rng.standard_normal(n)
    b = u[1] + 0.1 * rng.standard_normal(n)
    q[:, 0] += c * a - s * b
    q[:, 1] += s * a + c * b
    q[:, 2] += u[2] + 0.06 * rng.standard_normal(n)
    ecart = lidar_lot(q, 36) - z
    L = np.prod(0.8 * np.exp(-0.5 * (ecart / 0.3) ** 2) + 0.05, axis=1)
    w = w * L
    w = w / w.sum()
    if 1 / (w**2).sum() < n / 2:
        i = rng.choice(n, n, p=w)
        # les copies gardent le poids de leur vraisemblance pour désigner la meilleure, à un rien près
        q, w = q[i], np.full(n, 1 / n) * (1 + 1e-9 * L[i] / L.max())
        w = w / w.sum()
    return q, w


def estimer(p, w):
    return p[np.argmax(w)]

_pas_sans_injection = pas_mcl


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    n = len(p)
    candidats = np.asarray(initialiser(200))
    cout = np.minimum(np.abs(lidar_lot(candidats, 12) - scan[::3]), 2.0).sum(axis=1)
    meilleurs = candidats[np.argsort(cout)[: n // 20]]
    places = rng.choice(n, len(meilleurs), replace=False)
    p[places] = meilleurs + rng.normal(0, 0.03, meilleurs.shape)
    w[places] = 1.0 / n
    return p, w / w.sum()
