"""A system solved rather than an inverse; quantiles by the incomplete gamma function."""
from scipy.special import gammaincinv


def nees(vraie, estimee, P):
    e = estimee - vraie
    return e.dot(np.linalg.solve(P, e))


def bande(n, N, niveau=0.95):
    return tuple(2 * gammaincinv(n * N / 2, p) / N for p in ((1 - niveau) / 2, (1 + niveau) / 2))


def coherence(vraies, estimees, covariances):
    liste = [nees(*essai) for essai in zip(vraies, estimees, covariances)]
    moyenne = sum(liste) / len(liste)
    bas, haut = bande(len(vraies[0]), len(liste))
    return [moyenne, np.sign(moyenne - haut) * (moyenne > haut) + np.sign(moyenne - bas) * (moyenne < bas)]
