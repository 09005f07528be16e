def reechantillonner_systematique(particules, poids):
    copies = np.floor(len(poids) * poids + 1e-9).astype(int)
    return particules[np.repeat(np.arange(len(poids)), copies)]
