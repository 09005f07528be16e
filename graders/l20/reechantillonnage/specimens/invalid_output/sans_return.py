def n_eff(poids):
    print(1 / np.sum(poids**2))


def reechantillonner_systematique(particules, poids):
    particules = np.array(particules)
