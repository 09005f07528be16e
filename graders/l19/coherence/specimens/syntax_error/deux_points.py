def nees(vraie, estimee, P):
    e = vraie - estimee
    return e @ np.linalg.inv(P) @ e


def bande(n, N, niveau=0.95)
    return 0, 1


def coherence(vraies, estimees, covariances):
    return 1, 0
