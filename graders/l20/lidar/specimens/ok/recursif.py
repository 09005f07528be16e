import math


def lancer_rayon(libres, x, y, angle, portee_max):
    c, s = math.cos(angle), math.sin(angle)

    def est_mur(i, j):
        return not (0 <= i < len(libres[0]) and 0 <= j < len(libres) and libres[j][i])

    def suite(i, j, t):
        if t >= portee_max:
            return portee_max
        if est_mur(i, j):
            return t
        tx = ((i + 1 if c > 0 else i) - x) / c if abs(c) > 1e-12 else math.inf
        ty = ((j + 1 if s > 0 else j) - y) / s if abs(s) > 1e-12 else math.inf
        if tx < ty:
            return suite(i + (1 if c > 0 else -1), j, tx)
        return suite(i, j + (1 if s > 0 else -1), ty)

    return suite(math.floor(x), math.floor(y), 0.0)
