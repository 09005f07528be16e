"""The trace of P⁻¹ e eᵀ, and a global sum compared with the law of the sum."""
from scipy.stats import chi2


def nees(vraie, estimee, P):
    return np.trace(np.linalg.inv(P) @ np.outer(vraie - estimee, vraie - estimee))


def bande(n, N, niveau=0.95):
    somme = chi2.ppf(np.array([(1 - niveau) / 2, 1 - (1 - niveau) / 2]), n * N)
    return list(somme / N)


def coherence(vraies, estimees, covariances):
    N, n = vraies.shape
    somme = sum(map(nees, vraies, estimees, covariances))
    probabilite = chi2.cdf(somme, n * N)
    return somme / N, -1 if probabilite < 0.025 else 1 if probabilite > 0.975 else 0
