# La carte ne change pas pendant une exécution : on relève une fois pour toutes les cases libres,
# et ce que le lidar verrait au centre de chacune, cap 0, avec 4 rayons.
Y, X = np.nonzero(libres)
ATTENDUS = lidar_lot(np.column_stack([X + 0.5, Y + 0.5, np.zeros(len(X))]), 4)

# La carte entourée d'une case de mur : sortir de la grille devient un choc comme un autre.
CARTE = np.pad(libres, 1)


def arrivees(du, dv):
    """Les déplacements possibles (probabilité, selon x, selon y) quand on demande (du, dv)."""
    if (du, dv) == (0, 0):
        return [(1.0, 0, 0)]
    # (dv, du) est perpendiculaire à (du, dv) : le robot avance ET glisse, il tombe donc en diagonale.
    return [(0.8, du, dv), (0.1, du + dv, dv + du), (0.1, du - dv, dv - du)]


def predire2d(bel, du, dv):
    """La croyance après l'ordre (du, dv) : chaque case libre distribue sa probabilité sur ses arrivées."""
    nouvelle = np.zeros((H, W))
    for p, dx, dy in arrivees(du, dv):
        passe = CARTE[Y + dy + 1, X + dx + 1]
        # Là où l'arrivée est un mur, le robot reste sur sa case : sa probabilité aussi.
        arrivee = (np.where(passe, Y + dy, Y), np.where(passe, X + dx, X))
        # np.add.at additionne bien quand deux cases envoient leur probabilité au même endroit.
        np.add.at(nouvelle, arrivee, p * bel[Y, X])
    return nouvelle


def corriger2d(bel, scan_obs, sigma=0.5):
    """La croyance après le scan : on multiplie par la vraisemblance, puis on ramène la somme à 1."""
    carres = np.sum((scan_obs - ATTENDUS) ** 2, axis=1)
    nouvelle = np.zeros((H, W))
    nouvelle[Y, X] = bel[Y, X] * np.exp(-carres / (2 * sigma**2))
    return nouvelle / nouvelle.sum()
