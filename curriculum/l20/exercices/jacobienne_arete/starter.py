def residu(xi, xj, z):
    """La pose xj vue depuis xi, moins la mesure z : (3,)."""
    # À vous de jouer.
    return np.zeros(3)


def jacobiennes(xi, xj, z):
    """Les dérivées du résidu : A par xi, B par xj, (3, 3)."""
    return np.zeros((3, 3)), np.zeros((3, 3))


def contribution(xi, xj, z, omega):
    """Ce que l'arête ajoute : H (6, 6) et b (6,)."""
    return np.zeros((6, 6)), np.zeros(6)
