def predire2d(bel, du, dv):
    nouvelle = bel.copy()
    if (du, dv) == (0, 0):
        return nouvelle
    for p, dx, dy in arrivees(du, dv):
        passe = CARTE[Y + dy + 1, X + dx + 1]
        np.add.at(nouvelle, (np.where(passe, Y + dy, Y), np.where(passe, X + dx, X)), p * bel[Y, X])
    return nouvelle
