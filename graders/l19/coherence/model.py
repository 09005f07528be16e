from scipy.special import gammaincinv


def nees(vraie, estimee, P):
    e = vraie - estimee
    return e @ np.linalg.inv(P) @ e


def quantile(p, k):
    return 2 * gammaincinv(k / 2, p)


def bande(n, N, niveau=0.95):
    reste = (1 - niveau) / 2
    bas = quantile(reste, n * N) / N
    haut = quantile(1 - reste, n * N) / N
    return bas, haut


def coherence(vraies, estimees, covariances):
    N, n = vraies.shape
    valeurs = [nees(vraies[i], estimees[i], covariances[i]) for i in range(N)]
    moyenne = np.mean(valeurs)
    bas, haut = bande(n, N)
    avis = 0
    if moyenne > haut:
        avis = 1
    if moyenne < bas:
        avis = -1
    return moyenne, avis
