"""No numpy at all: 2 by 2 inverses by hand, elimination for the rest."""
from math import log

from scipy.stats import chi2


def distances2(z, amers, S):
    D = []
    for x, y in z:
        ligne = []
        for (u, v), ((a, b), (_, c)) in zip(amers, S):
            ex, ey = x - u, y - v
            ligne.append((c * ex * ex - 2 * b * ex * ey + a * ey * ey) / (a * c - b * b))
        D.append(ligne)
    return D


def porte(niveau):
    return -2 * log(1 - niveau)


def associer(z, amers, S, niveau=0.99):
    D = distances2(z, amers, S)
    mesures, poteaux = set(range(len(z))), set(range(len(amers)))
    choix = [-1 for _ in z]
    while mesures and poteaux:
        d, i, k = min((D[i][k], i, k) for i in mesures for k in poteaux)
        if d > porte(niveau):
            break
        choix[i] = k
        mesures.remove(i)
        poteaux.remove(k)
    return choix


def nouveaux(z, amers, S, niveau=0.99):
    return [i for i, ligne in enumerate(distances2(z, amers, S)) if all(d > porte(niveau) for d in ligne)]


def carre(M, h):
    M = [list(map(float, ligne)) + [x] for ligne, x in zip(M, h)]
    n = len(h)
    total = 0.0
    for c in range(n):
        total += M[c][n] ** 2 / M[c][c]
        for r in range(c + 1, n):
            f = M[r][c] / M[c][c]
            M[r] = [x - f * y for x, y in zip(M[r], M[c])]
    return total


def hypotheses(m, l):
    if m == 0:
        yield ()
        return
    for debut in hypotheses(m - 1, l):
        for k in range(-1, l):
            if k == -1 or k not in debut:
                yield (*debut, k)


def associer_ensemble(z, amers, C, R, niveau=0.99):
    gagnante, clef = [-1] * len(z), (0, 0.0)
    for H in hypotheses(len(z), len(amers)):
        p = [(i, k) for i, k in enumerate(H) if k > -1]
        if not p or len(p) < -clef[0]:
            continue
        h = [float(z[i][c] - amers[k][c]) for i, k in p for c in (0, 1)]
        M = [
            [C[2 * ka + a][2 * kb + b] + (R[a][b] if ia == ib else 0.0) for ib, kb in p for b in (0, 1)]
            for ia, ka in p
            for a in (0, 1)
        ]
        d = carre(M, h)
        if d <= chi2.ppf(niveau, len(h)) and (-len(p), d) < clef:
            gagnante, clef = list(H), (-len(p), d)
    return gagnante
