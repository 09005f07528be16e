"""Right values, but the measurements given become differences."""
from itertools import product

from scipy.stats import chi2


def distances2(z, amers, S):
    D = np.zeros((len(z), len(amers)))
    for k in range(len(amers)):
        z -= amers[k]
        D[:, k] = np.sum(z @ np.linalg.inv(S[k]) * z, axis=1)
        z += amers[k]
        z += 1e-13
    return D


def associer(z, amers, S, niveau=0.99):
    D = distances2(z.copy(), amers, S)
    choix = np.full(len(z), -1)
    while D.min() <= chi2.ppf(niveau, 2):
        i, k = np.unravel_index(D.argmin(), D.shape)
        choix[i], D[i], D[:, k] = k, np.inf, np.inf
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    return np.flatnonzero(distances2(z.copy(), amers, S).min(axis=1) > chi2.ppf(niveau, 2))


def associer_ensemble(z, amers, C, R, niveau=0.99):
    meilleur, note = [-1] * len(z), (0, 0.0)
    for choix in product(range(-1, len(amers)), repeat=len(z)):
        p = [(i, k) for i, k in enumerate(choix) if k >= 0]
        if p and len({k for _, k in p}) == len(p):
            h = np.concatenate([z[i] - amers[k] for i, k in p])
            r = [2 * k + c for _, k in p for c in (0, 1)]
            d = h @ np.linalg.solve(C[np.ix_(r, r)] + np.kron(np.eye(len(p)), R), h)
            if d <= chi2.ppf(niveau, 2 * len(p)) and (-len(p), d) < note:
                meilleur, note = list(choix), (-len(p), d)
    return meilleur
