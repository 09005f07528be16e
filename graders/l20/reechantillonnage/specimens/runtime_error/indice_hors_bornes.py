def n_eff(poids):
    return 1 / sum(poids**2)


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    return np.array([particules[i + 1] for i in np.searchsorted(np.cumsum(poids), (np.arange(n) + rng.random()) / n)])
