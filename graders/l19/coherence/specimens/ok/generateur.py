from scipy.stats.distributions import chi2


def les_nees(vraies, estimees, covariances):
    for e, P in zip(np.subtract(vraies, estimees), covariances):
        yield e @ np.linalg.pinv(P) @ e


def nees(*essai):
    return next(les_nees(*([un] for un in essai)))


def bande(n, N, niveau=0.95):
    k = n * N
    return chi2.ppf((1 - niveau) / 2, k) / N, chi2.ppf((1 + niveau) / 2, k) / N


def coherence(vraies, estimees, covariances):
    valeurs = list(les_nees(vraies, estimees, covariances))
    bas, haut = bande(len(vraies[0]), len(valeurs))
    moyenne = np.mean(valeurs)
    return (moyenne, 1) if moyenne > haut else (moyenne, -1) if moyenne < bas else (moyenne, 0)
