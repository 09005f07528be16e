"""The direction by its angle."""
import math


def distance_et_jacobien(x, balise):
    angle = math.atan2(x[1] - balise[1], x[0] - balise[0])
    H = math.cos(angle), math.sin(angle)
    return H[0] * (x[0] - balise[0]) + H[1] * (x[1] - balise[1]), H


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    H = np.asarray(H)
    croisee = np.einsum("ij,j->i", P, H)
    S = np.einsum("i,i->", H, croisee) + r
    return x + croisee * (z - d) / S, P - np.einsum("i,j->ij", croisee, croisee) / S
