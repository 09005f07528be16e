def n_eff(poids):
    """Le nombre effectif de particules d'un nuage dont les poids
    ont pour somme 1.
    """
    # À vous de jouer.
    return 0.0


def reechantillonner_systematique(particules, poids):
    """Un nouveau nuage (N, d) : des copies des particules, en
    nombre proportionnel à leurs poids.
    """
    N, d = particules.shape
    # À vous de jouer : un seul nombre aléatoire suffit.
    return np.zeros((N, d))
