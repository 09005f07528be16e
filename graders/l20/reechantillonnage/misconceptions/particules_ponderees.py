def reechantillonner_systematique(particules, poids):
    return particules * poids[:, None]
