# Augmented MCL : on injecte quand la vraisemblance moyenne chute (état gardé d'un appel à l'autre).
LENTE, RAPIDE = 0.0, 0.0


def initialiser(n):
    global LENTE, RAPIDE
    LENTE = RAPIDE = 0.0
    cases = np.argwhere(libres)
    tirage = cases[rng.integers(0, len(cases), n)]
    return np.hstack([tirage[:, ::-1] + rng.random((n, 2)), rng.uniform(-np.pi, np.pi, (n, 1))])


def bouger(p, u):
    n = len(p)
    e = u + rng.standard_normal((n, 3)) * (0.08, 0.08, 0.05)
    z = np.exp(1j * p[:, 2]) * (e[:, 0] + 1j * e[:, 1])
    return np.column_stack([p[:, 0] + z.real, p[:, 1] + z.imag, p[:, 2] + e[:, 2]])


def pas_mcl(particules, poids, u, scan):
    global LENTE, RAPIDE
    p = bouger(np.asarray(particules), u)
    n = len(p)
    carres = np.minimum((lidar_lot(p, 18) - scan[::2]) ** 2, 4.0)
    moyenne = np.exp(-carres / (2 * 0.4**2)).mean(axis=1) @ np.asarray(poids)
    l = -carres.sum(axis=1) / (2 * 0.4**2)
    w = np.asarray(poids) * np.exp(l - l.max())
    w = w / w.sum()
    LENTE += 0.05 * (moyenne - LENTE) if LENTE else moyenne
    RAPIDE += 0.5 * (moyenne - RAPIDE) if RAPIDE else moyenne
    part = max(0.0, 1.0 - RAPIDE / LENTE)
    if 1 / (w @ w) < n / 2 or part > 0:
        dents = (np.arange(n) + rng.random()) / n
        p = p[np.searchsorted(np.cumsum(w)[:-1], dents)]
        perdues = np.flatnonzero(rng.random(n) < part)
        if len(perdues):
            cases = np.argwhere(libres)[rng.integers(0, libres.sum(), len(perdues))]
            p[perdues] = np.column_stack([cases[:, 1] + rng.random(len(perdues)), cases[:, 0] + rng.random(len(perdues)), rng.uniform(-np.pi, np.pi, len(perdues))])
        w = np.ones(n) / n
    return p, w


def estimer(particules, poids):
    p = np.asarray(particules)
    return np.array([np.average(p[:, 0], weights=poids), np.average(p[:, 1], weights=poids),
                     np.angle(np.sum(poids * np.exp(1j * p[:, 2])))])
