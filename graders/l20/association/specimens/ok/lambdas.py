from itertools import product

from scipy.stats import chi2

distances2 = lambda z, amers, S: np.array([[(p - a) @ np.linalg.inv(P) @ (p - a) for a, P in zip(amers, S)] for p in z])
suite = lambda D, g, c: (
    c if D.min() > g else (lambda i, k: suite(raye(D, i, k), g, {**c, i: k}))(*np.unravel_index(D.argmin(), D.shape))
)
raye = lambda D, i, k: np.where((np.arange(len(D))[:, None] == i) | (np.arange(D.shape[1]) == k), np.inf, D)
liste = lambda c, m: [int(c.get(i, -1)) for i in range(m)]
associer = lambda z, amers, S, niveau=0.99: liste(suite(distances2(z, amers, S), chi2.ppf(niveau, 2), {}), len(z))
nouveaux = lambda z, amers, S, niveau=0.99: [
    i for i, d in enumerate(distances2(z, amers, S).min(axis=1)) if d > chi2.ppf(niveau, 2)
]
paires = lambda c: [(i, k) for i, k in enumerate(c) if k >= 0]
rangs = lambda p: [2 * k + x for _, k in p for x in range(2)]
ecarts = lambda p, z, a: np.concatenate([z[i] - a[k] for i, k in p]) if p else np.zeros(0)
forme = lambda h, M: h @ np.linalg.solve(M, h) if len(h) else 0.0
D2 = lambda c, z, a, C, R: forme(
    ecarts(paires(c), z, a), C[np.ix_(rangs(paires(c)), rangs(paires(c)))] + np.kron(np.eye(len(paires(c))), R)
)
unique = lambda c: len({k for k in c if k >= 0}) == len(paires(c))
permis = lambda c, z, a, C, R, p: unique(c) and (not paires(c) or D2(c, z, a, C, R) <= chi2.ppf(p, 2 * len(paires(c))))
associer_ensemble = lambda z, amers, C, R, niveau=0.99: list(
    min(
        (c for c in product(range(-1, len(amers)), repeat=len(z)) if permis(c, z, amers, C, R, niveau)),
        key=lambda c: (-len(paires(c)), D2(c, z, amers, C, R)),
    )
)
