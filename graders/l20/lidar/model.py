import math


def mur(libres, colonne, ligne):
    hauteur, largeur = libres.shape
    if colonne < 0 or ligne < 0:
        return True
    if colonne >= largeur or ligne >= hauteur:
        return True
    return not libres[ligne, colonne]


def direction(angle):
    return math.cos(angle), math.sin(angle)


def avancer(libres, x, y, dx, dy, portee_max):
    colonne, ligne, d = math.floor(x), math.floor(y), 0.0
    for _ in range(100):
        if mur(libres, colonne, ligne):
            return d
        bord_x = (colonne + (dx > 0) - x) / dx if dx else math.inf
        bord_y = (ligne + (dy > 0) - y) / dy if dy else math.inf
        d = min(bord_x, bord_y)
        if d >= portee_max:
            break
        if bord_x < bord_y:
            colonne += 1 if dx > 0 else -1
        else:
            ligne += 1 if dy > 0 else -1
    return portee_max


def lancer_rayon(libres, x, y, angle, portee_max):
    dx, dy = direction(angle)
    return avancer(libres, x, y, dx, dy, portee_max)
