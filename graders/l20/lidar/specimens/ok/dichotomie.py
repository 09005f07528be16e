def lancer_rayon(libres, x, y, angle, portee_max):
    H, W = libres.shape

    def libre(t):
        a, b = x + t * np.cos(angle), y + t * np.sin(angle)
        return 0 <= a < W and 0 <= b < H and libres[int(b), int(a)]

    t = 0
    while libre(t):
        if t >= portee_max:
            return portee_max
        t += 0.1
    bas, haut = t - 0.1, t
    for _ in range(30):
        milieu = (bas + haut) / 2
        if libre(milieu):
            bas = milieu
        else:
            haut = milieu
    return min(haut, portee_max)
