def vers_logodds(p):
    """Le log-odds d'une probabilité ; np.log accepte un nombre comme un tableau."""
    return np.log(p / (1 - p))


def vers_proba(l):
    """La probabilité d'un log-odds."""
    # Pour l très négatif, exp(-l) déborde vers l'infini, et 1 / infini vaut bien 0.
    return 1 / (1 + np.exp(-l))


L_OCC = np.log(0.7 / 0.3)
PETIT_PAS = 1e-6


def case_du_rayon(x, y, angle, d):
    """La case (ligne, colonne) du point situé à la distance d. La partie entière, et non int : −0,2 est dehors."""
    return int(np.floor(y + d * np.sin(angle))), int(np.floor(x + d * np.cos(angle)))


def integrer_scan(l, pose, scan, portee_max):
    """La grille de log-odds après un scan de plus ; celle qui est donnée reste intacte."""
    x, y, theta = pose
    nouvelle = np.array(l, dtype=float)
    hauteur, largeur = nouvelle.shape
    for k, z in enumerate(scan):
        angle = theta + 2 * np.pi * k / len(scan)
        # Des petits pas, d'un cinquantième de case ; le dictionnaire ne garde chaque case qu'une fois.
        votes = {case_du_rayon(x, y, angle, d): -L_OCC for d in np.arange(0, min(z, portee_max), 0.05)}
        # Un rayon qui lit la portée n'a touché aucun mur. Sinon, la case d'arrêt est celle du point situé juste après
        # la distance lue : sur la face du mur, un arrondi donnerait la case d'avant. Elle n'est pas traversée.
        if z < portee_max:
            votes[case_du_rayon(x, y, angle, z + PETIT_PAS)] = L_OCC
        for (i, j), vote in votes.items():
            # Un mur peut arrêter le rayon hors de la grille : un indice négatif désignerait l'autre bord.
            if 0 <= i < hauteur and 0 <= j < largeur:
                nouvelle[i, j] += vote
    return np.clip(nouvelle, -5, 5)
