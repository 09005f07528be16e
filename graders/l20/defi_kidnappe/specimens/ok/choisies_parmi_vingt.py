BRUIT_DU_PAS = np.array([0.08, 0.08, 0.05])
SIGMA = 0.4
# À chaque pas, une particule sur vingt est semée de nouveau, et choisie parmi vingt poses d'après le scan.
PART_INJECTEE, ESSAIS = 0.05, 20


def initialiser(n):
    """n poses au hasard sur les cases libres, cap compris."""
    cases = np.argwhere(libres)
    y, x = cases[rng.integers(len(cases), size=n)].T
    return np.column_stack([x + rng.random(n), y + rng.random(n), rng.uniform(-np.pi, np.pi, n)])


def deplacer(particules, u):
    """Chaque particule fait le pas u dans son propre repère, avec un bruit tiré pour elle seule."""
    dx, dy, virage = (np.asarray(u) + BRUIT_DU_PAS * rng.standard_normal((len(particules), 3))).T
    x, y, cap = np.asarray(particules, dtype=float).T
    c, s = np.cos(cap), np.sin(cap)
    return np.column_stack([x + c * dx - s * dy, y + s * dx + c * dy, cap + virage])


def log_vraisemblances(particules, scan):
    """Un logarithme par particule ; le coût d'un rayon est borné, celui qui frôle un coin n'élimine personne."""
    ecarts = lidar_lot(particules, 12) - np.asarray(scan)[::3]
    return -np.minimum((ecarts / SIGMA) ** 2 / 2, 6.0).sum(axis=1)


def tirer(log_poids, combien):
    """Les numéros tirés par le peigne, à proportion de l'exponentielle de log_poids."""
    w = np.exp(log_poids - log_poids.max())
    dents = (rng.random() + np.arange(combien)) / combien
    return np.searchsorted(np.cumsum(w / w.sum())[:-1], dents)


def poses_vraisemblables(combien, scan):
    """Des poses où le robot pourrait être, à ne regarder que ce scan : on en sème beaucoup, on garde les meilleures."""
    candidates = initialiser(ESSAIS * combien)
    return candidates[tirer(log_vraisemblances(candidates, scan), combien)]


def pas_mcl(particules, poids, u, scan):
    """Bouger, peser, rééchantillonner, et semer quelques particules là où le scan les rend plausibles."""
    particules = deplacer(particules, u)
    n = len(particules)
    with np.errstate(divide="ignore"):
        log_poids = np.log(poids) + log_vraisemblances(particules, scan)
    poids = np.exp(log_poids - log_poids.max())
    poids /= poids.sum()
    if 1.0 / np.sum(poids**2) < n / 2:
        particules = particules[tirer(log_poids, n)]
        poids = np.full(n, 1.0 / n)
    # Une pose que personne n'occupe ne gagnera jamais : on injecte des candidats, même si tout semble aller bien.
    nouvelles = rng.choice(n, max(1, round(PART_INJECTEE * n)), replace=False)
    particules[nouvelles] = poses_vraisemblables(len(nouvelles), scan)
    return particules, poids


def estimer(particules, poids):
    """La moyenne des particules proches de la mieux entourée : les poses injectées ailleurs ne la déplacent pas."""
    p, w = np.asarray(particules, dtype=float), np.asarray(poids, dtype=float)
    voisines = np.hypot(p[:, None, 0] - p[None, ::5, 0], p[:, None, 1] - p[None, ::5, 1]) < 1.0
    proches = voisines[:, np.argmax(w @ voisines)]
    x, y, cap = p[proches].T
    v = w[proches] / w[proches].sum()
    return np.array([v @ x, v @ y, np.arctan2(v @ np.sin(cap), v @ np.cos(cap))])
