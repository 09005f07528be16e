def reechantillonner_systematique(particules, poids):
    copies = np.round(len(poids) * poids).astype(int)
    return particules[np.repeat(np.arange(len(poids)), copies)]
