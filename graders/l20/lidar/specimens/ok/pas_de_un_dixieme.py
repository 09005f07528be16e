from math import cos, floor, sin


def lancer_rayon(libres, x, y, angle, portee_max):
    H, W = libres.shape
    t = 0.0
    while t < portee_max:
        i = floor(x + t * cos(angle))
        j = floor(y + t * sin(angle))
        if i < 0 or j < 0 or i >= W or j >= H or not libres[j][i]:
            return t
        t += 0.1
    return portee_max
