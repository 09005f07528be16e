"""Positions as complex numbers, for the gates; a heap of pairs."""
import heapq
from itertools import product

from scipy.stats import chi2


def distances2(z, amers, S):
    u = np.asarray(z) @ [1, 1j]
    a = np.asarray(amers) @ [1, 1j]
    e = u[:, None] - a
    W = np.linalg.inv(S)
    return W[:, 0, 0] * e.real**2 + 2 * W[:, 0, 1] * e.real * e.imag + W[:, 1, 1] * e.imag**2


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    tas = [(D[i, k], i, k) for i, k in np.ndindex(D.shape) if D[i, k] <= chi2.ppf(niveau, 2)]
    heapq.heapify(tas)
    choix, pris = [-1] * len(z), set()
    while tas:
        _, i, k = heapq.heappop(tas)
        if choix[i] == -1 and k not in pris:
            choix[i] = k
            pris.add(k)
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    return np.flatnonzero(chi2.cdf(distances2(z, amers, S).min(axis=1), 2) > niveau)


def associer_ensemble(z, amers, C, R, niveau=0.99):
    def note(choix):
        paires = [(i, k) for i, k in enumerate(choix) if k >= 0]
        n = len(paires)
        if len({k for _, k in paires}) < n:
            return (1, 0.0)
        if n == 0:
            return (0, 0.0)
        G = np.zeros((2 * n, len(C)))
        for p, (_, k) in enumerate(paires):
            G[2 * p : 2 * p + 2, 2 * k : 2 * k + 2] = np.eye(2)
        h = np.concatenate([z[i] - amers[k] for i, k in paires])
        d = h @ np.linalg.lstsq(G @ C @ G.T + np.kron(np.eye(n), R), h, rcond=None)[0]
        return (-n, d) if d <= chi2.ppf(niveau, 2 * n) else (1, 0.0)

    return min(product(range(-1, len(amers)), repeat=len(z)), key=note)
