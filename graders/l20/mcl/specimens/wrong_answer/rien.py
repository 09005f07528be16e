def initialiser(n):
    return np.ones((n, 3))


def pas_mcl(particules, poids, u, scan):
    return particules, poids


def estimer(particules, poids):
    return np.zeros(3)
