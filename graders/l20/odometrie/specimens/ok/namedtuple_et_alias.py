"""A named tuple, names of its own, the kit's np under another name."""
from collections import namedtuple

from l20 import np as numpy

Pose = namedtuple("Pose", "x y theta")


def odometrie(p, gauche, droite, largeur):
    p = Pose(*p)
    avance, rotation = (gauche + droite) / 2, (droite - gauche) / largeur
    direction = p.theta + rotation / 2
    return Pose(
        p.x + avance * numpy.cos(direction),
        p.y + avance * numpy.sin(direction),
        numpy.angle(numpy.exp(1j * (p.theta + rotation))),
    )


def sigma_dtheta(s1, s2, largeur):
    return numpy.sqrt(numpy.sum(numpy.square([s1, s2]))) / largeur
