def reechantillonner_systematique(particules, poids):
    N = len(poids)
    cumul = np.cumsum(poids)
    cumul[-1] = 1.0
    decalage = np.random.default_rng(0).random()
    return particules[np.searchsorted(cumul, (np.arange(N) + decalage) / N)]
