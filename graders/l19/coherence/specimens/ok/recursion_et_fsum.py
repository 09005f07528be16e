import math

from scipy.stats import chi2


def nees(vraie, estimee, P):
    """By successive conditioning: one component at a time."""
    e, P = vraie - estimee, np.array(P)
    if len(e) == 1:
        return e[0] ** 2 / P[0, 0]
    pente = P[1:, 0] / P[0, 0]
    return e[0] ** 2 / P[0, 0] + nees(e[1:] - pente * e[0], np.zeros(len(e) - 1), P[1:, 1:] - np.outer(pente, P[0, 1:]))


def bande(n, N, niveau=0.95):
    reste = (1.0 - niveau) / 2.0
    return chi2.ppf(reste, n * N) / N, chi2.ppf(1.0 - reste, n * N) / N


def coherence(vraies, estimees, covariances):
    N = len(vraies)
    moyenne = math.fsum(nees(vraies[i], estimees[i], covariances[i]) for i in range(N)) / N
    bas, haut = bande(vraies[0].size, N)
    return moyenne, (0, 1)[int(moyenne > haut)] - (0, 1)[int(moyenne < bas)]
