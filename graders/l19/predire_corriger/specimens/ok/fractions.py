"""Exact arithmetic, and back to floats at the end."""
from fractions import Fraction


def exacts(*nombres):
    return [Fraction(nombre) for nombre in nombres]


def predire(m, v, u, q):
    m, v, u, q = exacts(m, v, u, q)
    return float(m + u), float(v + q)


def corriger(m, v, z, r):
    m, v, z, r = exacts(m, v, z, r)
    K = v / (v + r)
    return float(m + K * (z - m)), float(v * (1 - K))
