"""bisect from the standard library, itertools for the running sum, a list of rows returned."""
from bisect import bisect_left
from itertools import accumulate


def n_eff(poids):
    return 1.0 / sum(map(lambda p: p * p, poids))


def reechantillonner_systematique(particules, poids):
    n = len(poids)
    fins = list(accumulate(poids))
    u = rng.uniform(0, 1 / n)
    return [list(particules[min(bisect_left(fins, u + m / n), n - 1)]) for m in range(n)]
