def n_eff(poids):
    return 1 / np.sum(poids**2


def reechantillonner_systematique(particules, poids):
    return particules
