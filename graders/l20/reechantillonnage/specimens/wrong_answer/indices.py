def n_eff(poids):
    return 1 / np.sum(poids**2)


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    return np.searchsorted(np.cumsum(poids), (np.arange(n) + rng.random()) / n)
