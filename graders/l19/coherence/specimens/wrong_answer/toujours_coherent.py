from scipy.stats import chi2


def nees(vraie, estimee, P):
    e = vraie - estimee
    return e @ np.linalg.inv(P) @ e


def bande(n, N, niveau=0.95):
    return 0.0, float("inf")


def coherence(vraies, estimees, covariances):
    return np.mean([nees(*t) for t in zip(vraies, estimees, covariances)]), 0
