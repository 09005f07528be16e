def predire2d(bel, du, dv):
    nouvelle = np.zeros((H, W))
    for p, dx, dy in arrivees(du, dv):
        passe = CARTE[Y + dy + 1, X + dx + 1]
        np.add.at(nouvelle, (Y[passe] + dy, X[passe] + dx), p * bel[Y[passe], X[passe]])
    return nouvelle / nouvelle.sum()
