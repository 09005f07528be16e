def reechantillonner_systematique(particules, poids):
    return particules[np.full(len(poids), np.argmax(poids))]
