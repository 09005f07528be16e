import math

from scipy.ndimage import distance_transform_edt


def lancer_rayon(libres, x, y, angle, portee_max):
    # Une boule sans mur autour du point : on peut y avancer sans regarder.
    carte = np.pad(libres, 1)
    marge = distance_transform_edt(carte)
    t = 0.0
    while t < portee_max:
        i, j = math.floor(x + t * math.cos(angle)) + 1, math.floor(y + t * math.sin(angle)) + 1
        if not carte[j, i]:
            return t
        t += max(0.04, marge[j, i] - 1.5)
    return portee_max
