"""Nothing from numpy."""
from math import cos, sin


def avance(pas):
    return tuple(float(x) * cos(t / 2) + float(y) * sin(t / 2) for x, y, t in pas)


def produit(u, v):
    return sum(a * b for a, b in zip(u, v))


def etalonner(pas, vrais):
    d, dv = avance(pas), avance(vrais)
    t, tv = [ligne[2] for ligne in pas], [ligne[2] for ligne in vrais]
    # On retire de t ce qui ressemble à d : le reste ne dépend plus que de beta.
    part = produit(t, d) / produit(d, d)
    reste = [a - part * b for a, b in zip(t, d)]
    beta = produit(reste, tv) / produit(reste, reste)
    alpha = produit(d, [a - beta * b for a, b in zip(tv, t)]) / produit(d, d)
    return produit(d, dv) / produit(d, d), beta, alpha


def corriger(pas, gamma, beta, alpha):
    resultat = []
    for (x, y, t), d in zip(pas, avance(pas)):
        neuf = beta * t + alpha * d
        a = neuf / 2 - t / 2
        resultat.append([gamma * x * cos(a) - gamma * y * sin(a), gamma * x * sin(a) + gamma * y * cos(a), neuf])
    return resultat
