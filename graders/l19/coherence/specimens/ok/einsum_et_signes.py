"""All runs at once; the verdict as a difference of two comparisons."""
import scipy.stats


def nees(vraie, estimee, P):
    e = vraie - estimee
    return np.einsum("i,ij,j->", e, np.linalg.inv(P), e)


def bande(n, N, niveau=0.95):
    return np.array(scipy.stats.chi2.interval(niveau, n * N)) / N


def coherence(vraies, estimees, covariances):
    e = vraies - estimees
    moyenne = np.einsum("ki,kij,kj->k", e, np.linalg.inv(covariances), e).mean()
    bas, haut = bande(e.shape[1], len(e))
    return moyenne, int(moyenne > haut) - int(moyenne < bas)
