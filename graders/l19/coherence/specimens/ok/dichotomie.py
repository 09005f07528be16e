"""The quantile found by bisection of the distribution function."""
from scipy.special import gammainc


def quantile(p, k):
    bas, haut = 0.0, 10.0 * k + 100.0
    for _ in range(200):
        milieu = (bas + haut) / 2
        bas, haut = (milieu, haut) if gammainc(k / 2, milieu / 2) < p else (bas, milieu)
    return (bas + haut) / 2


def nees(vraie, estimee, P):
    return np.linalg.multi_dot([vraie - estimee, np.linalg.inv(P), vraie - estimee])


def bande(n, N, niveau=0.95):
    return quantile((1 - niveau) / 2, n * N) / N, quantile((1 + niveau) / 2, n * N) / N


def coherence(vraies, estimees, covariances):
    moyenne = np.mean([nees(*t) for t in zip(vraies, estimees, covariances)])
    bas, haut = bande(vraies.shape[-1], vraies.shape[0])
    return np.array([moyenne, (moyenne > haut) * 1 - (moyenne < bas) * 1])
