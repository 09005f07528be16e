def reechantillonner_systematique(particules, poids):
    N = len(poids)
    cumul = np.cumsum(poids)
    cumul[-1] = 1.0
    decalage = rng.random() / N
    return particules[np.searchsorted(cumul, (np.arange(N) + decalage) / N)]
