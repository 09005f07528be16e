import math


def lancer_rayon(libres, x, y, angle, portee_max):
    hauteur, largeur = libres.shape
    t = 0.0
    while t < portee_max:
        j, i = math.floor(y + t * math.sin(angle)), math.floor(x + t * math.cos(angle))
        if not (0 <= j < hauteur and 0 <= i < largeur) or not libres[j, i]:
            return t
        t += 0.2
    return portee_max
