def initialiser(n):
    cases = np.argwhere(libres)
    y, x = cases[rng.integers(len(cases), size=n)].T
    return np.column_stack([x + rng.random(n), y + rng.random(n), rng.uniform(-np.pi, np.pi, n)])


def deplacer(particules, u):
    n = len(particules)
    bruit = np.array([0.08, 0.08, 0.05]) * rng.standard_normal((n, 3))
    dx, dy, virage = (u + bruit).T
    x, y, cap = particules.T
    c, s = np.cos(cap), np.sin(cap)
    return np.column_stack([x + c * dx - s * dy, y + s * dx + c * dy, cap + virage])


def log_vraisemblances(particules, scan):
    attendus = lidar_lot(particules, 36)
    ecarts = (scan - attendus) / 0.4
    return -np.minimum(ecarts**2 / 2, 6.0).sum(axis=1)


def peser(particules, poids, scan):
    l = log_vraisemblances(particules, scan)
    w = poids * np.exp(l - l.max())
    return w / w.sum()


def reechantillonner(particules, poids):
    n = len(poids)
    dents = (rng.random() + np.arange(n)) / n
    indices = np.searchsorted(np.cumsum(poids)[:-1], dents)
    return particules[indices], np.full(n, 1.0 / n)


def pas_mcl(particules, poids, u, scan):
    nouvelles = deplacer(particules, u)
    w = peser(nouvelles, poids, scan)
    if 1.0 / np.sum(w**2) < len(w) / 2:
        nouvelles, w = reechantillonner(nouvelles, w)
    return nouvelles, w


def estimer(particules, poids):
    x, y, cap = particules.T
    theta = np.arctan2(poids @ np.sin(cap), poids @ np.cos(cap))
    return np.array([poids @ x, poids @ y, theta])
