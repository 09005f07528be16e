def lancer_rayon(libres, x, y, angle, portee_max):
    lignes, colonnes = libres.shape
    px, py, t = x, y, 0.0
    vx, vy = np.cos(angle) * 0.001, np.sin(angle) * 0.001
    while 0 <= px < colonnes and 0 <= py < lignes and libres[int(py), int(px)]:
        px += vx
        py += vy
        t += 0.001
        if t >= portee_max:
            return portee_max
    return t
