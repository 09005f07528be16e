def predire2d(bel, du, dv):
    """La croyance (H, W) après l'ordre d'avancer de (du, dv) :
    du selon x (colonnes), dv selon y (lignes).
    """
    nouvelle = np.zeros((H, W))
    # À vous de jouer : chaque case libre distribue sa probabilité
    # sur ses arrivées possibles.
    return nouvelle


def corriger2d(bel, scan_obs, sigma=0.5):
    """La croyance (H, W) après le scan de 4 rayons scan_obs ;
    sigma est l'écart-type de chaque distance.
    """
    nouvelle = bel.copy()
    # À vous de jouer : depuis la case (y, x), que verrait
    # lidar((x + 0.5, y + 0.5, 0.0), 4) ?
    return nouvelle
