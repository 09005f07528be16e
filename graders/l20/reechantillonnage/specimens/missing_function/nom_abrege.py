def n_eff(poids):
    return 1 / np.sum(poids**2)


def reechantillonner(particules, poids):
    return particules
