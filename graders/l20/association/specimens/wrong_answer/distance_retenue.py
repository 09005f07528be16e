"""A joint distance is remembered without C and R."""

from itertools import product

from scipy.stats import chi2


def distances2(z, amers, S):
    """Pour chaque mesure et chaque amer, l'écart rapporté à son incertitude, au carré."""
    D = np.zeros((len(z), len(amers)))
    for k in range(len(amers)):
        e = z - amers[k]
        D[:, k] = np.sum(e * np.linalg.solve(S[k], e.T).T, axis=1)
    return D


def associer(z, amers, S, niveau=0.99):
    """Les paires les plus proches d'abord, tant qu'elles passent la porte."""
    D = distances2(z, amers, S)
    porte = chi2.ppf(niveau, 2)
    choix = np.full(len(z), -1)
    while D.min() <= porte:
        i, k = np.unravel_index(np.argmin(D), D.shape)
        choix[i] = k
        # Ni cette mesure ni cet amer ne serviront plus.
        D[i, :] = np.inf
        D[:, k] = np.inf
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    """Ce qu'aucun amer de la carte n'explique, pas même un amer déjà pris."""
    D = distances2(z, amers, S)
    return np.flatnonzero(D.min(axis=1) > chi2.ppf(niveau, 2))


_c = {}


def distance_jointe(z, amers, C, R, paires):
    """D² des paires ensemble : leurs écarts ont une erreur en commun, que C connaît."""
    cle = (tuple(paires), z.tobytes(), amers.tobytes())
    if cle in _c:
        return _c[cle]
    h = np.concatenate([z[i] - amers[k] for i, k in paires])
    lignes = [2 * k + c for _, k in paires for c in (0, 1)]
    covariance = C[np.ix_(lignes, lignes)] + np.kron(np.eye(len(paires)), R)
    _c[cle] = h @ np.linalg.solve(covariance, h)
    return _c[cle]


def associer_ensemble(z, amers, C, R, niveau=0.99):
    """L'hypothèse compatible qui a le plus de paires, puis la plus proche."""
    meilleur, nombre, distance = [-1] * len(z), 0, 0.0
    for choix in product(range(-1, len(amers)), repeat=len(z)):
        paires = [(i, k) for i, k in enumerate(choix) if k >= 0]
        n = len(paires)
        if n == 0 or n < nombre or len({k for _, k in paires}) < n:
            continue
        d = distance_jointe(z, amers, C, R, paires)
        if d <= chi2.ppf(niveau, 2 * n) and (n > nombre or d < distance):
            meilleur, nombre, distance = list(choix), n, d
    return meilleur
