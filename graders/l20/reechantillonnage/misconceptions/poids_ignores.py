def reechantillonner_systematique(particules, poids):
    N = len(poids)
    return particules[rng.integers(N, size=N)]
