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
