"""Copies counted without any search, rows repeated."""
import math


def n_eff(poids):
    return math.fsum(p**2 for p in poids) ** -1


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    fins = np.floor(n * np.cumsum(poids) + rng.random())
    fins[-1] = n
    copies = np.diff(fins, prepend=0).astype(int)
    return np.repeat(particules, copies, axis=0)[:n]
