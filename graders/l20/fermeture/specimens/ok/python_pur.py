"""Elimination on lists; no matrix library."""
from math import cos, pi, sin

from scipy.stats import chi2


def inverse(M):
    n = len(M)
    T = [[float(M[r][c]) for c in range(n)] + [1.0 * (r == c) for c in range(n)] for r in range(n)]
    for c in range(n):
        p = max(range(c, n), key=lambda r: abs(T[r][c]))
        T[c], T[p] = T[p], T[c]
        T[c] = [x / T[c][c] for x in T[c]]
        for r in range(n):
            if r != c:
                T[r] = [x - T[r][c] * y for x, y in zip(T[r], T[c])]
    return [ligne[n:] for ligne in T]


def produit(A, B):
    return [[sum(a * b for a, b in zip(ligne, colonne)) for colonne in zip(*B)] for ligne in A]


def covariance_jointe(H, i, j):
    libre = inverse([list(ligne[3:]) for ligne in H[3:]])
    k = [3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2]
    return [[libre[a - 3][b - 3] if a > 2 and b > 2 else 0.0 for b in k] for a in k]


def covariance_relative(xi, xj, sigma):
    c, s = cos(xi[2]), sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    J = [[-c, -s, -s * dx + c * dy, c, s, 0], [s, -c, -c * dx - s * dy, -s, c, 0], [0, 0, -1, 0, 0, 1]]
    return produit(produit(J, sigma), list(zip(*J)))


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    c, s = cos(xi[2]), sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    a = (xj[2] - xi[2] - z[2]) % (2 * pi)
    e = [c * dx + s * dy - z[0], c * dy - s * dx - z[1], a if a <= pi else a - 2 * pi]
    P, Q = covariance_relative(xi, xj, sigma), inverse(omega)
    W = inverse([[p + q for p, q in zip(lp, lq)] for lp, lq in zip(P, Q)])
    d2 = sum(e[r] * W[r][t] * e[t] for r in range(3) for t in range(3))
    return d2, d2 <= chi2.ppf(niveau, 3)
