"""Sums of parabolas for the fusion; the gain from standard deviations squared again."""
import math


def gain(v, r):
    sigma, bruit = math.sqrt(v), math.sqrt(r)
    return (sigma / math.hypot(sigma, bruit)) ** 2


def fusionner(mesures, variances):
    a = math.fsum(1 / r for r in variances)
    b = math.fsum(-2 * z / r for z, r in zip(mesures, variances))
    return -b / (2 * a), 1 / a


def enchainer(m, v, mesures, variances):
    croyance = {"m": m, "v": v}
    lignes = []
    for z, r in zip(mesures, variances):
        S = croyance["v"] + r
        croyance = {"m": croyance["m"] + croyance["v"] * (z - croyance["m"]) / S, "v": croyance["v"] * r / S}
        lignes.append(list(croyance.values()))
    print(len(lignes), "croyances")
    return lignes
