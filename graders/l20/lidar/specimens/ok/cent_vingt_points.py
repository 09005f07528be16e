def lancer_rayon(libres, x, y, angle, portee_max):
    h, l = libres.shape
    for t in np.linspace(0, portee_max, 120):
        c, r = int(np.floor(x + t * np.cos(angle))), int(np.floor(y + t * np.sin(angle)))
        if not (0 <= r < h and 0 <= c < l and libres[r, c]):
            return t
    return portee_max
