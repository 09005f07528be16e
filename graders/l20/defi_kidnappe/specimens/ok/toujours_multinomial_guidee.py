def initialiser(n):
    indices = rng.choice(np.flatnonzero(libres), n)
    return np.c_[indices % W + rng.random(n), indices // W + rng.random(n), np.pi - 2 * np.pi * rng.random(n)]


def pas_mcl(particules, poids, u, scan):
    n = len(particules)
    bruit = rng.normal(0.0, [0.1, 0.1, 0.06], (n, 3))
    pas = u + bruit
    rot = np.array([[np.cos(particules[:, 2]), -np.sin(particules[:, 2])], [np.sin(particules[:, 2]), np.cos(particules[:, 2])]])
    xy = particules[:, :2] + np.einsum("ijn,nj->ni", rot, pas[:, :2])
    nuage = np.column_stack((xy, particules[:, 2] + pas[:, 2]))
    erreurs = np.sum(np.clip(lidar_lot(nuage, 12) - scan[::3], -1.5, 1.5) ** 2, axis=1)
    vraisemblance = np.exp(-(erreurs - erreurs.min()) / (2 * 0.4**2))
    p = vraisemblance / vraisemblance.sum()
    return nuage[rng.choice(n, size=n, p=p)], np.ones(n) / n


def estimer(particules, poids):
    x, y, _ = np.average(particules, axis=0, weights=poids)
    vecteur = np.average(np.exp(1j * particules[:, 2]), weights=poids)
    return x, y, np.angle(vecteur)

_pas_sans_injection = pas_mcl


def pas_mcl(particules, poids, u, scan):
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    n = len(p)
    candidats = np.asarray(initialiser(600))
    cout = np.minimum(np.abs(lidar_lot(candidats, 12) - scan[::3]), 2.0).sum(axis=1)
    meilleurs = candidats[np.argsort(cout)[: n // 20]]
    places = rng.choice(n, len(meilleurs), replace=False)
    p[places] = meilleurs + rng.normal(0, 0.03, meilleurs.shape)
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
