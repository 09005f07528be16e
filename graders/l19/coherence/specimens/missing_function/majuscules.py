from scipy.stats import chi2


def NEES(vraie, estimee, P):
    e = vraie - estimee
    return e @ np.linalg.inv(P) @ e


def intervalle(n, N, niveau=0.95):
    return chi2.ppf((1 - niveau) / 2, n * N) / N, chi2.ppf((1 + niveau) / 2, n * N) / N


def est_coherent(vraies, estimees, covariances):
    return True
