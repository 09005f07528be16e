def reechantillonner_systematique(particules, poids):
    N = len(poids)
    cumul = np.cumsum(poids)
    cumul[-1] = 1.0
    return particules[np.searchsorted(cumul, (np.arange(N) + rng.random(N)) / N)]
