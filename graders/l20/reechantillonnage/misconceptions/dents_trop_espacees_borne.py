def reechantillonner_systematique(particules, poids):
    N = len(poids)
    dents = np.linspace(0, 1, N) + rng.random() / N
    return particules[np.minimum(np.searchsorted(np.cumsum(poids), dents), N - 1)]
