from collections import namedtuple

from scipy.stats import chi2

Bande = namedtuple("Bande", "bas haut")
Jugement = namedtuple("Jugement", "moyenne avis")


def nees(vraie, estimee, P):
    e = vraie.copy()
    e -= estimee
    return float(e @ np.linalg.lstsq(P, e, rcond=None)[0])


def bande(n, N, niveau=0.95):
    p = (1 - niveau) / 2
    return Bande(chi2.ppf(p, n * N) / N, chi2.ppf(1 - p, n * N) / N)


def coherence(vraies, estimees, covariances):
    total, k = 0.0, 0
    while k < len(vraies):
        total += nees(vraies[k], estimees[k], covariances[k])
        k += 1
    moyenne = total / k
    b = bande(vraies.shape[1], k)
    return Jugement(moyenne, -1 if moyenne < b.bas else int(moyenne > b.haut))
