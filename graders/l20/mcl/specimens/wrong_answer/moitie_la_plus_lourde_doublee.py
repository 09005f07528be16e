def initialiser(n):
    cases = np.argwhere(libres)
    particules = []
    for _ in range(n):
        y, x = cases[rng.integers(len(cases))]
        particules.append([x + rng.random(), y + rng.random(), rng.uniform(-np.pi, np.pi)])
    return np.array(particules)


def pas_mcl(particules, poids, u, scan):
    n = len(particules)
    dx = rng.normal(u[0], 0.06, n)
    dy = rng.normal(u[1], 0.06, n)
    dt = rng.normal(u[2], 0.04, n)
    x, y, t = particules.T
    nouv = np.column_stack([x + dx * np.cos(t) - dy * np.sin(t),
                            y + dx * np.sin(t) + dy * np.cos(t),
                            t + dt])
    attendus = lidar_lot(nouv, 36)
    logl = -np.sum((attendus - scan)**2, axis=1) / (2 * 0.5**2)
    w = poids * np.exp(logl - np.max(logl))
    w /= np.sum(w)
    if 1 / np.sum(w**2) < n / 2:
        # rééchantillonner
        ordre = np.argsort(w)[::-1]
        moitie = ordre[:(n + 1) // 2]
        choix = np.concatenate([moitie, moitie])[:n]
        nouv = nouv[choix]
        w = np.ones(n) / n
    return nouv, w


def estimer(particules, poids):
    c = np.sum(poids * np.cos(particules[:, 2]))
    s = np.sum(poids * np.sin(particules[:, 2]))
    return np.array([poids @ particules[:, 0], poids @ particules[:, 1], np.arctan2(s, c)])
