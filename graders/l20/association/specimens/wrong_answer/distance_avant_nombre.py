"""A smaller distance comes before a greater number of pairs."""

import numpy as np
from scipy.stats import chi2

def distances2(z, amers, S):
    e = z[:,None,:]-amers[None]
    return np.einsum('ika,kab,ikb->ik', e, np.linalg.inv(S), e)

def associer(z, amers, S, niveau=0.99):
    d = distances2(z, amers, S)
    g = chi2.ppf(niveau, 2)
    res = [-1]*len(z)
    while d.min() <= g:
        i, k = np.unravel_index(np.argmin(d), d.shape)
        res[i] = int(k)
        d[i,:] = np.inf
        d[:,k] = np.inf
    return res

def nouveaux(z, amers, S, niveau=0.99):
    d = distances2(z, amers, S)
    return [i for i in range(len(z)) if d[i].min() > chi2.ppf(niveau, 2)]

def associer_ensemble(z, amers, C, R, niveau=0.99):
    m, l = len(z), len(amers)
    best = (0, 0.0, [-1]*m)
    def explore(i, hyp):
        nonlocal best
        if i == m:
            paires = [(a,k) for a,k in enumerate(hyp) if k >= 0]
            n = len(paires)
            if n == 0 or n < best[0]:
                return
            h = np.concatenate([z[a]-amers[k] for a,k in paires])
            idx = np.array([[2*k,2*k+1] for _,k in paires]).ravel()
            M = C[np.ix_(idx,idx)] + np.kron(np.eye(n), R)
            D = h @ np.linalg.solve(M, h)
            if D <= chi2.ppf(niveau, 2*n) and (D < best[1] or best[0]==0):
                best = (n, D, list(hyp))
            return
        for k in list(range(l))+[-1]:
            if k == -1 or k not in hyp:
                explore(i+1, hyp+[k])
    explore(0, [])
    return best[2]
