def lancer_rayon(libres, x, y, angle, portee_max):
    dx, dy = round(np.cos(angle)), round(np.sin(angle))
    t = 0.0
    while t < portee_max:
        j, i = int(y + t * dy), int(x + t * dx)
        if j < 0 or i < 0 or j >= libres.shape[0] or i >= libres.shape[1] or not libres[j, i]:
            return t
        t += 0.05
    return portee_max
