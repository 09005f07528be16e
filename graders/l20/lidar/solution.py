import math


def lancer_rayon(libres, x, y, angle, portee_max):
    """La distance du point (x, y) au premier mur dans la direction angle, au plus portee_max."""
    hauteur, largeur = libres.shape
    dx, dy = math.cos(angle), math.sin(angle)
    colonne, ligne = math.floor(x), math.floor(y)
    # Le sens de la marche dans les indices : +1 ou −1.
    pas_x, pas_y = int(math.copysign(1, dx)), int(math.copysign(1, dy))

    # Le rayon saute de ligne en ligne de la grille : entre deux lignes, il reste dans la même case.
    # prochain_x est la distance, le long du rayon, de la prochaine ligne verticale : x = colonne + 1
    # vers la droite, x = colonne vers la gauche. ecart_x sépare deux de ces lignes.
    # Un rayon exactement vertical (dx nul) n'en rencontre aucune.
    prochain_x = (colonne + (1 + pas_x) / 2 - x) / dx if dx else math.inf
    prochain_y = (ligne + (1 + pas_y) / 2 - y) / dy if dy else math.inf
    ecart_x = pas_x / dx if dx else math.inf
    ecart_y = pas_y / dy if dy else math.inf

    while True:
        # On franchit la plus proche des deux lignes, et l'on change de case de ce côté-là.
        distance = min(prochain_x, prochain_y)
        if distance == prochain_x:
            colonne += pas_x
            prochain_x += ecart_x
        else:
            ligne += pas_y
            prochain_y += ecart_y
        # Hors de la grille, tout est mur. Le demander avant de lire libres évite aussi les indices
        # négatifs, que numpy lirait à l'autre bout du tableau.
        dedans = 0 <= colonne < largeur and 0 <= ligne < hauteur
        if not dedans or not libres[ligne, colonne]:
            # Un mur plus loin que la portée n'est pas vu.
            return min(distance, portee_max)
