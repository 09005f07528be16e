def gonfler(grille, rayon, resolution):
    """Les cases permises au centre du robot (H, W)."""
    # À vous de jouer.
    return np.zeros((1, 1), dtype=bool)


def cout(chemin, couts):
    """Le prix d'un chemin : chaque pas, et ses deux cases."""
    return -1.0


def planifier(permises, couts, depart, but):
    """Les cases du meilleur chemin, du départ au but."""
    return [(-1, -1)]
