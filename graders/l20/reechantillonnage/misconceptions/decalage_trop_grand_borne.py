def reechantillonner_systematique(particules, poids):
    N = len(poids)
    dents = np.arange(N) / N + rng.random()
    return particules[np.minimum(np.searchsorted(np.cumsum(poids), dents), N - 1)]
