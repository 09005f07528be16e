"""scipy's distances, column by column; whitened errors for the whole."""
from itertools import product

from scipy.linalg import block_diag, solve_triangular
from scipy.spatial.distance import cdist
from scipy.stats import chi2


def distances2(z, amers, S):
    return np.hstack([cdist(z, [a], "mahalanobis", VI=np.linalg.inv(P)) ** 2 for a, P in zip(amers, S)])


def associer(z, amers, S, niveau=0.99):
    D, porte = distances2(z, amers, S), chi2(2).ppf(niveau)
    reponse = -np.ones(len(z), dtype=int)
    ordre = np.argsort(D, axis=None)
    for rang in ordre:
        i, k = np.unravel_index(rang, D.shape)
        if D[i, k] > porte:
            break
        if reponse[i] < 0 and not np.any(reponse == k):
            reponse[i] = k
    return reponse


def nouveaux(z, amers, S, niveau=0.99):
    return np.nonzero(np.min(distances2(z, amers, S), axis=1) > chi2(2).ppf(niveau))[0].tolist()


def associer_ensemble(z, amers, C, R, niveau=0.99):
    bilan = {}
    for choix in product(range(-1, len(amers)), repeat=len(z)):
        poteaux = [k for k in choix if k != -1]
        if len(poteaux) != len(set(poteaux)) or not poteaux:
            continue
        h = np.ravel([z[i] - amers[k] for i, k in enumerate(choix) if k != -1])
        r = [x for k in poteaux for x in (2 * k, 2 * k + 1)]
        L = np.linalg.cholesky(C[np.ix_(r, r)] + block_diag(*[R] * len(poteaux)))
        d = np.sum(solve_triangular(L, h, lower=True) ** 2)
        if d <= chi2(len(h)).ppf(niveau):
            bilan[choix] = (-len(poteaux), d)
    return list(min(bilan, key=bilan.get)) if bilan else [-1] * len(z)
