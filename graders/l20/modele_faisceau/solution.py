import math


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    """Σ ln p(z_k) : chaque rayon s'explique par quatre causes, dont les densités s'additionnent."""
    a_hit, a_short, a_max, a_rand = alpha
    # Bon écho : une cloche autour de la distance attendue. Sa constante compte, car elle pèse
    # cette cause face aux trois autres.
    p = a_hit * np.exp(-((z - z_attendu) ** 2) / (2 * sigma**2)) / (sigma * np.sqrt(2 * np.pi))
    # Objet imprévu : seulement avant le mur. Le tableau de booléens vaut 1 là où z ≤ ẑ, 0 ailleurs.
    p += a_short * lam * np.exp(-lam * z) * (z <= z_attendu)
    # Rien vu : le rayon lit la portée.
    p += a_max * (z >= z_max)
    # N'importe quoi : la même densité partout.
    p += a_rand / z_max
    # Les rayons sont pris pour indépendants : leurs probabilités se multiplient, donc leurs
    # logarithmes s'ajoutent. Le produit lui-même s'annulerait : 400 facteurs de 0,01 donnent 10⁻⁸⁰⁰.
    return np.sum(np.log(p))


def champ_distance(libres):
    """La distance (H, W) de chaque case à la case de mur la plus proche, de centre à centre."""
    hauteur, largeur = libres.shape
    murs = np.argwhere(~libres)
    champ = np.zeros((hauteur, largeur))
    for y in range(hauteur):
        for x in range(largeur):
            # Les murs eux-mêmes sont à distance 0 d'eux-mêmes : rien de spécial à faire pour eux.
            champ[y, x] = min(math.dist((y, x), mur) for mur in murs)
    return champ
