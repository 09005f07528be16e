def reechantillonner_systematique(particules, poids):
    N = len(poids)
    cumul = np.cumsum(poids)
    cumul[-1] = 1.0
    indices = np.searchsorted(cumul, (np.arange(N) + rng.random()) / N)
    return particules[indices], np.full(N, 1.0 / N)
