def predire2d(bel, du, dv):
    nouvelle = np.zeros((H, W))
    devant = CARTE[Y + dv + 1, X + du + 1]
    for p, dx, dy in arrivees(du, dv):
        passe = CARTE[Y + dy + 1, X + dx + 1]
        y = np.where(passe, Y + dy, np.where(devant, Y + dv, Y))
        x = np.where(passe, X + dx, np.where(devant, X + du, X))
        np.add.at(nouvelle, (y, x), p * bel[Y, X])
    return nouvelle
