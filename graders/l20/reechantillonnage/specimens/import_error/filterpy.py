from filterpy.monte_carlo import systematic_resample


def n_eff(poids):
    return 1 / np.sum(poids**2)


def reechantillonner_systematique(particules, poids):
    return particules[systematic_resample(poids)]
