def predire2d(bel, du, dv):
    nouvelle = np.zeros((H, W))
    for p, dx, dy in arrivees(du, dv):
        y, x = (Y + dy) % H, (X + dx) % W
        passe = libres[y, x]
        np.add.at(nouvelle, (np.where(passe, y, Y), np.where(passe, x, X)), p * bel[Y, X])
    return nouvelle
