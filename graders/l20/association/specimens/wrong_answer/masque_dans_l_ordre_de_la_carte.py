"""A mask takes the rows of C in the order of the map, whatever the order of the pairs."""

import numpy as np
from scipy.stats import chi2


def distances2(z, amers, S):
    m, l = z.shape[0], amers.shape[0]
    res = np.zeros((m, l))
    for i in range(m):
        for k in range(l):
            v = z[i] - amers[k]
            res[i, k] = v @ np.linalg.inv(S[k]) @ v
    return res


def associer(z, amers, S, niveau=0.99):
    g = chi2.ppf(niveau, 2)
    d = distances2(z, amers, S)
    out = -np.ones(len(z), dtype=int)
    while d.min() <= g:
        pos = d.argmin()
        i, k = pos // d.shape[1], pos % d.shape[1]
        out[i] = k
        d[i] = d[:, k] = np.inf
    return out


def nouveaux(z, amers, S, niveau=0.99):
    g = chi2.ppf(niveau, 2)
    return [i for i, d in enumerate(distances2(z, amers, S)) if d.min() > g]


def hypotheses(m, l):
    """Toutes les listes de m entiers, sans amer repete."""
    if m == 0:
        yield []
        return
    for debut in hypotheses(m - 1, l):
        yield debut + [-1]
        for k in range(l):
            if k not in debut:
                yield debut + [k]


def associer_ensemble(z, amers, C, R, niveau=0.99):
    meilleur = [-1] * len(z)
    n_max, d_min = 0, np.inf
    for hyp in hypotheses(len(z), len(amers)):
        hyp = np.array(hyp)
        vus = np.flatnonzero(hyp >= 0)
        n = len(vus)
        if n == 0 or n < n_max:
            continue
        h = (z[vus] - amers[hyp[vus]]).ravel()
        garde = np.repeat(np.isin(np.arange(len(amers)), hyp[vus]), 2)
        cov = C[garde][:, garde] + np.kron(np.eye(n), R)
        D2 = h @ np.linalg.solve(cov, h)
        if D2 <= chi2.ppf(niveau, 2 * n) and (n > n_max or D2 < d_min):
            n_max, d_min, meilleur = n, D2, hyp.tolist()
    return meilleur
