"""The error made white, then its length squared."""
from scipy.linalg import solve_triangular
from scipy.stats import chi2


def blanchie(e, P):
    return solve_triangular(np.linalg.cholesky(P), e, lower=True)


def nees(vraie, estimee, P):
    return float(np.sum(blanchie(vraie - estimee, P) ** 2))


def bande(dimension, essais, niveau=0.95):
    loi = chi2(dimension * essais)
    return loi.ppf(0.5 - niveau / 2) / essais, loi.ppf(0.5 + niveau / 2) / essais


def coherence(vraies, estimees, covariances):
    essais, dimension = np.shape(vraies)
    somme = 0.0
    for k in range(essais):
        somme += nees(vraies[k], estimees[k], covariances[k])
    bas, haut = bande(dimension, essais)
    avis = 0 if bas <= somme / essais <= haut else 1 if somme / essais > haut else -1
    return somme / essais, avis
