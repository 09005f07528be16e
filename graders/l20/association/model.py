from itertools import product

from scipy.special import gammaincinv


def seuil(niveau, n):
    return 2 * gammaincinv(n / 2, niveau)


def distances2(z, amers, S):
    D = np.zeros((len(z), len(amers)))
    for k in range(len(amers)):
        W = np.linalg.inv(S[k])
        for i in range(len(z)):
            e = z[i] - amers[k]
            D[i, k] = e @ W @ e
    return D


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    porte = seuil(niveau, 2)
    choix = np.full(len(z), -1)
    D[porte < D] = np.inf
    while np.min(D) < np.inf:
        i, k = np.unravel_index(np.argmin(D), D.shape)
        choix[i] = k
        D[i, :] = np.inf
        D[:, k] = np.inf
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    porte = seuil(niveau, 2)
    return np.flatnonzero(np.min(D, axis=1) > porte)


def distance_jointe(z, amers, C, R, paires):
    h = np.concatenate([z[i] - amers[k] for i, k in paires])
    lignes = [2 * k + c for _, k in paires for c in (0, 1)]
    M = C[np.ix_(lignes, lignes)] + np.kron(np.eye(len(paires)), R)
    return h @ np.linalg.solve(M, h)


def associer_ensemble(z, amers, C, R, niveau=0.99):
    meilleur, nombre, distance = [-1] * len(z), 0, 0.0
    for choix in product(range(-1, len(amers)), repeat=len(z)):
        paires = [(i, k) for i, k in enumerate(choix) if k >= 0]
        n = len(paires)
        if n == 0 or n < nombre:
            continue
        if len({k for _, k in paires}) < n:
            continue
        d = distance_jointe(z, amers, C, R, paires)
        if d > seuil(niveau, 2 * n):
            continue
        if n > nombre or d < distance:
            meilleur, nombre, distance = list(choix), n, d
    return meilleur
