def initialiser(n):
    """n poses (x, y, theta) au hasard sur les cases libres."""
    particules = np.zeros((n, 3))
    # À vous de jouer.
    return particules


def pas_mcl(particules, poids, u, scan):
    """Un tour de filtre : les particules bougent de
    u = (dx, dy, dtheta), le scan de 36 rayons les pèse, et l'on
    rééchantillonne au besoin.
    """
    # À vous de jouer : déplacer, peser, rééchantillonner.
    return particules, poids


def estimer(particules, poids):
    """La pose (3,) que le nuage annonce."""
    # À vous de jouer.
    return np.zeros(3)
