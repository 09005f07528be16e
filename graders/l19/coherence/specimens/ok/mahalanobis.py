from scipy.spatial.distance import mahalanobis
from scipy.stats import chi2


def nees(vraie, estimee, P):
    return mahalanobis(vraie, estimee, np.linalg.inv(P)) ** 2


def bande(n, N, niveau=0.95):
    bas, haut = chi2.ppf([(1 - niveau) / 2, (1 + niveau) / 2], df=n * N)
    return bas / N, haut / N


def coherence(vraies, estimees, covariances):
    N, n = vraies.shape
    moyenne = np.fromiter((nees(vraies[i], estimees[i], covariances[i]) for i in range(N)), float).mean()
    bas, haut = bande(n, N)
    avis = {(True, False): 1, (False, True): -1}.get((moyenne > haut, moyenne < bas), 0)
    print("NEES moyen", moyenne)
    return moyenne, avis
