def initialiser(n):
    """n poses (x, y, theta) au hasard sur les cases libres."""
    particules = np.zeros((n, 3))
    # À vous de jouer (ou de reprendre votre fonction).
    return particules


def pas_mcl(particules, poids, u, scan):
    """Un tour de filtre, qui garde une chance de se reprendre
    quand le robot a été enlevé.
    """
    # À vous : déplacer, peser, rééchantillonner, injecter.
    return particules, poids


def estimer(particules, poids):
    """La pose (3,) que le nuage annonce."""
    # À vous de jouer.
    return np.zeros(3)
