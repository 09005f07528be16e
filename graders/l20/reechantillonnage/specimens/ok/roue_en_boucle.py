"""The classical loop with a moving cursor, pure Python, lists out, other parameter names, the module's own `random`."""
import random


def n_eff(w):
    total = 0.0
    for x in w:
        total += x * x
    return 1 / total


def reechantillonner_systematique(X, w):
    M = len(X)
    r = random.uniform(0, 1 / M)
    c, i = w[0], 0
    nouvelles = []
    for m in range(M):
        U = r + m / M
        while U > c and i < M - 1:
            i = i + 1
            c = c + w[i]
        nouvelles.append(list(X[i]))
    return nouvelles
