"""Polar coordinates: a rotation adds to the azimuth."""
import math


def tourner(x, y, angle):
    r, azimut = math.hypot(x, y), math.atan2(y, x)
    return r * math.cos(azimut + angle), r * math.sin(azimut + angle)


def ramener(t):
    return math.remainder(t, math.tau)


def composer(a, b):
    u, v = tourner(b[0], b[1], a[2])
    return a[0] + u, a[1] + v, ramener(a[2] + b[2])


def inverse(a):
    u, v = tourner(a[0], a[1], math.pi - a[2])
    return u, v, ramener(-a[2])


def relatif(a, b):
    u, v = tourner(b[0] - a[0], b[1] - a[1], -a[2])
    return u, v, ramener(b[2] - a[2])
