def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    """La somme sur les rayons de ln p(z).

    z et z_attendu : tableaux (n,) ; alpha : les quatre parts
    (bon écho, objet imprévu, portée, hasard).
    """
    hit, short, maxi, rand = alpha
    # À vous de jouer : la densité de chaque rayon, puis la
    # somme de ses logarithmes.
    return 0.0


def champ_distance(libres):
    """Un tableau (H, W) : pour chaque case, l'écart au mur
    le plus proche, compté en cases d'un centre à l'autre
    (0 sur un mur).
    """
    hauteur, largeur = libres.shape
    champ = np.zeros((hauteur, largeur))
    # À vous de jouer : où sont les murs ?
    return champ
