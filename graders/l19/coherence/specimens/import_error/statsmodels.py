from statsmodels.stats import chi2


def nees(vraie, estimee, P):
    return 0


def bande(n, N, niveau=0.95):
    return chi2.ppf(0.025, n * N), chi2.ppf(0.975, n * N)


def coherence(vraies, estimees, covariances):
    return 0, 0
