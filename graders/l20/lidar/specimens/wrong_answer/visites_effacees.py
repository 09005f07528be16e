import math


def lancer_rayon(libres, x, y, angle, portee_max):
    murs = ~libres
    h, w = libres.shape
    libres[:] = False
    t = 0.0
    while t < portee_max:
        j, i = math.floor(y + t * math.sin(angle)), math.floor(x + t * math.cos(angle))
        if not (0 <= j < h and 0 <= i < w) or murs[j, i]:
            return t
        libres[j, i] = True
        t += 0.05
    return portee_max
