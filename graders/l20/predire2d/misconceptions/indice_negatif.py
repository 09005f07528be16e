def predire2d(bel, du, dv):
    nouvelle = np.zeros((H, W))
    for y, x in zip(Y, X):
        for p, dx, dy in arrivees(du, dv):
            if y + dy < H and x + dx < W and libres[y + dy, x + dx]:
                nouvelle[y + dy, x + dx] += p * bel[y, x]
            else:
                nouvelle[y, x] += p * bel[y, x]
    return nouvelle
