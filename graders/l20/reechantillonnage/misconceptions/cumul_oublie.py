def reechantillonner_systematique(particules, poids):
    N = len(poids)
    nouvelles = np.empty_like(particules)
    i, decalage = 0, rng.random()
    for m in range(N):
        while (m + decalage) / N > poids[i]:
            i += 1
        nouvelles[m] = particules[i]
    return nouvelles
