"""Loops over the steps, sums kept by hand, Cramer's rule."""
import math


def avance(pas):
    resultat = []
    for x, y, theta in pas:
        resultat.append(x * math.cos(theta / 2) + y * math.sin(theta / 2))
    return resultat


def etalonner(pas, vrais):
    tt = td = dd = tv = dv = ddv = 0.0
    for (theta, d, vrai, d_vrai) in zip(pas[:, 2], avance(pas), vrais[:, 2], avance(vrais)):
        tt += theta * theta
        td += theta * d
        dd += d * d
        tv += theta * vrai
        dv += d * vrai
        ddv += d * d_vrai
    det = tt * dd - td * td
    return ddv / dd, (tv * dd - dv * td) / det, (tt * dv - td * tv) / det


def corriger(pas, gamma, beta, alpha):
    lignes = []
    for (x, y, theta), d in zip(pas, avance(pas)):
        virage = beta * theta + alpha * d
        c, s = math.cos((virage - theta) / 2), math.sin((virage - theta) / 2)
        lignes.append([gamma * (c * x - s * y), gamma * (s * x + c * y), virage])
    return lignes
