from collections import namedtuple

Croyance = namedtuple("Croyance", ["moyenne", "variance"])


def predire(m, v, u, q):
    avant = Croyance(m, v)
    return avant._replace(moyenne=avant.moyenne + u, variance=avant.variance + q)


def corriger(m, v, z, r):
    avant = Croyance(m, v)
    part = avant.variance / (avant.variance + r)
    return Croyance(avant.moyenne - part * (avant.moyenne - z), avant.variance - part * avant.variance)
