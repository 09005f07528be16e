"""Sums without rounding: the weights as fractions."""
from fractions import Fraction


def n_eff(poids):
    return float(1 / sum(Fraction(float(p)) ** 2 for p in poids))


def reechantillonner_systematique(particules, poids):
    w = [Fraction(float(p)) for p in poids]
    total, n = sum(w), len(w)
    u = Fraction(float(rng.random()))
    resultat, fin, m = [], Fraction(0), 0
    for ligne, p in zip(particules, w):
        fin += p
        while m < n and (m + u) * total <= fin * n:
            resultat.append(tuple(ligne))
            m += 1
    return resultat
