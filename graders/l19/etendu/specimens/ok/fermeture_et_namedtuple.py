from collections import namedtuple

Mesure = namedtuple("Mesure", "d H")
Croyance = namedtuple("Croyance", "x P")


def capteur(balise):
    def lit(x):
        ecart = x - balise
        return Mesure(np.linalg.norm(ecart), ecart / np.linalg.norm(ecart))

    return lit


def distance_et_jacobien(x, balise):
    return capteur(balise)(x)


def corriger_distance(x, P, z, balise, r):
    vu = capteur(balise)(x)
    PH = P @ vu.H
    S = vu.H @ PH + r
    print("S =", S)
    return Croyance(x + PH * ((z - vu.d) / S), P - np.outer(PH, PH) / S)
