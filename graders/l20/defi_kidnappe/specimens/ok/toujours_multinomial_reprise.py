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


surprises = 0


def pas_mcl(particules, poids, u, scan):
    global surprises
    p, w = _pas_sans_injection(particules, poids, u, scan)
    p, w = np.array(p, dtype=float), np.array(w, dtype=float)
    ecart = np.median(np.abs(lidar_lot(p, 12) - scan[::3]), axis=1)
    surprises = surprises + 1 if np.min(ecart) > 0.25 or np.average(ecart, weights=w) > 0.5 else 0
    if surprises >= 3:  # le scan ne ressemble plus à rien : on recommence tout
        surprises = 0
        n = len(p)
        candidats = np.asarray(initialiser(12 * n))
        cout = np.minimum((lidar_lot(candidats, 12) - scan[::3]) ** 2, 4).sum(axis=1)
        l = np.exp(-(cout - cout.min()))
        return candidats[rng.choice(len(candidats), n, p=l / l.sum())], np.ones(n) / n
    return p, w
