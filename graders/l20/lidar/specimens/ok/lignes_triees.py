def lancer_rayon(libres, x, y, angle, portee_max):
    H, W = libres.shape
    dx, dy = np.cos(angle), np.sin(angle)
    t = [0.0, portee_max]
    if abs(dx) > 1e-9:
        t += list((np.arange(W + 1) - x) / dx)
    if abs(dy) > 1e-9:
        t += list((np.arange(H + 1) - y) / dy)
    t = np.unique([u for u in t if 0 <= u <= portee_max])
    for debut, fin in zip(t[:-1], t[1:]):
        milieu = (debut + fin) / 2
        i, j = x + milieu * dx, y + milieu * dy
        if not (0 < i < W and 0 < j < H and libres[int(j), int(i)]):
            return float(debut)
    return portee_max
