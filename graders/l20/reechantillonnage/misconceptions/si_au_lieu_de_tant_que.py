def reechantillonner_systematique(particules, poids):
    N = len(poids)
    nouvelles = np.empty_like(particules)
    i, cumul, decalage = 0, poids[0], rng.random()
    for m in range(N):
        if (m + decalage) / N > cumul and i < N - 1:
            i += 1
            cumul += poids[i]
        nouvelles[m] = particules[i]
    return nouvelles
