"""Decimals of thirty digits; the new variance by a continued halving of nothing: plain recursion on the pair."""
from decimal import Decimal, getcontext

getcontext().prec = 30


def somme(valeurs):
    return valeurs[0] + somme(valeurs[1:]) if len(valeurs) > 1 else valeurs[0]


def predire(m, v, u, q):
    return float(somme([Decimal(m), Decimal(u)])), float(somme([Decimal(v), Decimal(q)]))


def corriger(m, v, z, r):
    inverses = [1 / Decimal(v), 1 / Decimal(r)]
    total = somme(inverses)
    return float(somme([Decimal(m) * inverses[0], Decimal(z) * inverses[1]]) / total), float(1 / total)
