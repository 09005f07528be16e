def lancer_rayon(libres, x, y, angle, portee_max):
    t = np.arange(0, portee_max, 0.05)
    i = np.floor(x + t * np.cos(angle)).astype(int)
    j = np.floor(y + t * np.sin(angle)).astype(int)
    dedans = (i >= 0) & (i < libres.shape[1]) & (j >= 0) & (j < libres.shape[0])
    murs = np.ones(len(t), dtype=bool)
    murs[dedans] = ~libres[j[dedans], i[dedans]]
    return t[np.argmax(murs)] if murs.any() else portee_max
