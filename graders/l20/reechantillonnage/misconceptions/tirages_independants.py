def reechantillonner_systematique(particules, poids):
    N = len(poids)
    cumul = np.cumsum(poids)
    return particules[np.minimum(np.searchsorted(cumul, rng.random(N)), N - 1)]
