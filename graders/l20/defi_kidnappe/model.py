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
    ecarts = (scan[::3] - lidar_lot(particules, 12)) / 0.4
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


def plausibles(combien, scan):
    candidates = initialiser(20 * combien)
    l = log_vraisemblances(candidates, scan)
    w = np.exp(l - l.max())
    dents = (rng.random() + np.arange(combien)) / combien
    return candidates[np.searchsorted(np.cumsum(w / w.sum())[:-1], dents)]


def injecter(particules, poids, scan):
    n = len(particules)
    combien = int(np.ceil(0.05 * n))
    places = rng.choice(n, combien, replace=False)
    p, w = particules.copy(), poids.copy()
    p[places] = plausibles(combien, scan)
    w[places] = 1.0 / n
    return p, w / w.sum()


def pas_mcl(particules, poids, u, scan):
    nouvelles = deplacer(particules, u)
    w = peser(nouvelles, poids, scan)
    if 1.0 / np.sum(w**2) < len(w) / 2:
        nouvelles, w = reechantillonner(nouvelles, w)
    return injecter(nouvelles, w, scan)


def estimer(particules, poids):
    voisines = np.hypot(*(particules[:, None, :2] - particules[None, ::5, :2]).transpose(2, 0, 1)) < 1.0
    proches = voisines[:, np.argmax(poids @ voisines)]
    x, y, cap = particules[proches].T
    v = poids[proches] / poids[proches].sum()
    theta = np.arctan2(v @ np.sin(cap), v @ np.cos(cap))
    return np.array([v @ x, v @ y, theta])
