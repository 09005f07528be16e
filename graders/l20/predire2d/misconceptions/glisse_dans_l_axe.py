CARTE = np.pad(libres, 2)


def predire2d(bel, du, dv):
    nouvelle = np.zeros((H, W))
    for p, dx, dy in [(0.8, du, dv), (0.1, 2 * du, 2 * dv), (0.1, 0, 0)]:
        passe = CARTE[Y + dy + 2, X + dx + 2]
        np.add.at(nouvelle, (np.where(passe, Y + dy, Y), np.where(passe, X + dx, X)), p * bel[Y, X])
    return nouvelle
