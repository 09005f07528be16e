def lancer_rayon(libres, x, y, angle, portee_max):
    """La distance, en cases, du point (x, y) au premier mur
    dans la direction angle (en radians) ; au plus portee_max.

    libres[y, x] vaut True là où la case est libre ; hors de
    la grille, tout est mur.
    """
    hauteur, largeur = libres.shape
    # À vous de jouer : dans quelle case est (x, y) ?
    # Et dans laquelle le rayon entre-t-il ensuite ?
    return portee_max
