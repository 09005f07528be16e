import math


def cases(x, y, angle):
    """Les cases (colonne, ligne) traversées, avec la distance à laquelle on y entre."""
    c, s = math.cos(angle), math.sin(angle)
    i, j, t = math.floor(x), math.floor(y), 0.0
    while True:
        yield i, j, t
        tx = ((i + (c > 0)) - x) / c if c else float("inf")
        ty = ((j + (s > 0)) - y) / s if s else float("inf")
        t = min(tx, ty)
        if tx <= ty:
            i += 1 if c > 0 else -1
        if ty <= tx:
            j += 1 if s > 0 else -1


def lancer_rayon(libres, x, y, angle, portee_max):
    h, w = libres.shape
    mur = next(t for i, j, t in cases(x, y, angle) if not (0 <= i < w and 0 <= j < h and libres[j, i]))
    return min(mur, portee_max)
