def reechantillonner_systematique(particules, poids):
    N = len(poids)
    cumul = np.cumsum(np.sort(poids))
    cumul[-1] = 1.0
    return particules[np.searchsorted(cumul, (np.arange(N) + rng.random()) / N)]
