from scipy.stats import chi2

nees = lambda v, x, P: (v - x) @ np.linalg.solve(P, v - x)
bande = lambda n, N, niveau=0.95: [chi2.ppf(p, N * n) / N for p in ((1 - niveau) / 2, 1 - (1 - niveau) / 2)]
juge = lambda m, b: (m, 1 if m > b[1] else -1 if m < b[0] else 0)
coherence = lambda V, X, C: juge(np.mean(list(map(nees, V, X, C))), bande(V.shape[1], V.shape[0]))
