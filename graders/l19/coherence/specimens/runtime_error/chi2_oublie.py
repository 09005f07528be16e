"""The import is forgotten."""


def nees(vraie, estimee, P):
    return (vraie - estimee) @ np.linalg.invert(P) @ (vraie - estimee)


def bande(n, N, niveau=0.95):
    return chi2.ppf((1 - niveau) / 2, n * N) / N, chi2.ppf((1 + niveau) / 2, n * N) / N


def coherence(vraies, estimees, covariances):
    moyenne = np.mean([nees(*t) for t in zip(vraies, estimees, covariances)])
    bas, haut = bande(vraies.shape[1], len(vraies))
    return moyenne, int(moyenne > haut) - int(moyenne < bas)
