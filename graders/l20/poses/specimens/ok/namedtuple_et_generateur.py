from collections import namedtuple
from math import atan2, cos, sin

Cap = namedtuple("Cap", "c s")


def cap(t):
    return Cap(cos(t), sin(t))


def produit(u, v):
    return Cap(u.c * v.c - u.s * v.s, u.c * v.s + u.s * v.c)


def oppose(u):
    return Cap(u.c, -u.s)


def coordonnees(x, y, u, dx, dy):
    yield x + u.c * dx - u.s * dy
    yield y + u.s * dx + u.c * dy


def composer(a, b):
    ici, la = cap(a[2]), cap(b[2])
    bout = produit(ici, la)
    return [*coordonnees(a[0], a[1], ici, b[0], b[1]), atan2(bout.s, bout.c)]


def inverse(a):
    retour = oppose(cap(a[2]))
    return [*coordonnees(0, 0, retour, -a[0], -a[1]), atan2(retour.s, retour.c)]


def relatif(a, b):
    retour = oppose(cap(a[2]))
    bout = produit(retour, cap(b[2]))
    return [*coordonnees(0, 0, retour, b[0] - a[0], b[1] - a[1]), atan2(bout.s, bout.c)]
