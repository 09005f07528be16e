"""All distances at once; permutations with holes."""
from itertools import permutations

from scipy.stats import chi2


def distances2(z, amers, S):
    e = z[:, None] - amers[None]
    return np.einsum("mki,kij,mkj->mk", e, np.linalg.inv(S), e)


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    D[D > chi2.ppf(niveau, 2)] = np.inf
    choix = np.full(len(z), -1)
    for _ in range(min(D.shape)):
        i, k = divmod(int(D.argmin()), D.shape[1])
        if not np.isfinite(D[i, k]):
            break
        choix[i], D[i], D[:, k] = k, np.inf, np.inf
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    return np.where((distances2(z, amers, S) > chi2.ppf(niveau, 2)).all(axis=1))[0]


def associer_ensemble(z, amers, C, R, niveau=0.99):
    m, l = len(z), len(amers)
    essais = []
    for choix in set(permutations([*range(l), *[-1] * m], m)):
        c = np.array(choix)
        i = np.flatnonzero(c >= 0)
        if len(i) == 0:
            essais.append((0, 0.0, choix))
            continue
        h = (z[i] - amers[c[i]]).ravel()
        lignes = np.ravel(np.column_stack([2 * c[i], 2 * c[i] + 1]))
        d = h @ np.linalg.solve(C[np.ix_(lignes, lignes)] + np.kron(np.eye(len(i)), R), h)
        if d <= chi2.ppf(niveau, 2 * len(i)):
            essais.append((-len(i), d, choix))
    return np.array(min(essais)[2])
