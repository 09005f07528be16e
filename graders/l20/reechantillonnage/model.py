def n_eff(poids):
    return 1.0 / np.sum(poids**2)


def reechantillonner_systematique(particules, poids):
    N = len(poids)
    cumul = np.cumsum(poids)
    cumul[-1] = 1.0
    u = rng.random() / N
    dents = u + np.arange(N) / N
    indices = np.searchsorted(cumul, dents)
    return particules[indices]
