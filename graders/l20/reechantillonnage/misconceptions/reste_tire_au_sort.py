def reechantillonner_systematique(particules, poids):
    N = len(poids)
    copies = np.floor(N * poids + 1e-9).astype(int)
    reste = np.maximum(N * poids - copies, 0.0)
    manquantes = N - copies.sum()
    if manquantes:
        cumul = np.cumsum(reste / reste.sum())
        cumul[-1] = 1.0
        copies += np.bincount(np.searchsorted(cumul, rng.random(manquantes)), minlength=N)
    return particules[np.repeat(np.arange(N), copies)]
