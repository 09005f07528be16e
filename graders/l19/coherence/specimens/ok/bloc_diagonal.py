"""One large error and one large covariance; the mean is the NEES of the whole, divided by N."""
from scipy.linalg import block_diag, cho_factor, cho_solve
from scipy.stats import chi2


def nees(vraie, estimee, P):
    e = np.ravel(vraie) - np.ravel(estimee)
    return e @ cho_solve(cho_factor(P), e)


def bande(n, N, niveau=0.95):
    return chi2.isf((1 + niveau) / 2, n * N) / N, chi2.isf((1 - niveau) / 2, n * N) / N


def coherence(vraies, estimees, covariances):
    N, n = vraies.shape
    moyenne = nees(vraies, estimees, block_diag(*covariances)) / N
    bas, haut = bande(n, N)
    return moyenne, sum([moyenne > bas, moyenne > haut]) - 1
