"""Lists everywhere; Jacobi's rotations for the eigenvalues."""
from math import atan2, cos, hypot, sin


def normales(Q):
    N, dernier = [], len(Q) - 1
    for k in range(dernier + 1):
        avant, apres = Q[k - 1 if k else 0], Q[k + 1 if k < dernier else dernier]
        u, v = apres[0] - avant[0], apres[1] - avant[1]
        N.append((-v / hypot(u, v), u / hypot(u, v)))
    return N


def systeme_droite(P, Q, N):
    n = len(P)
    cx, cy = sum(p[0] for p in P) / n, sum(p[1] for p in P) / n
    A, g = [[0.0] * 3 for _ in range(3)], [0.0] * 3
    for p, q, m in zip(P, Q, N):
        j = (m[0], m[1], m[1] * (p[0] - cx) - m[0] * (p[1] - cy))
        r = m[0] * (p[0] - q[0]) + m[1] * (p[1] - q[1])
        for a in range(3):
            g[a] += j[a] * r / n
            for b in range(3):
                A[a][b] += j[a] * j[b] / n
    return A, g


def jacobi(A):
    M = [[float(x) for x in ligne] for ligne in A]
    V = [[1.0 if a == b else 0.0 for b in range(3)] for a in range(3)]
    for _ in range(30):
        for a, b in ((0, 1), (0, 2), (1, 2)):
            t = atan2(2 * M[a][b], M[a][a] - M[b][b]) / 2
            c, s = cos(t), sin(t)
            for k in range(3):
                M[k][a], M[k][b] = c * M[k][a] + s * M[k][b], c * M[k][b] - s * M[k][a]
                V[k][a], V[k][b] = c * V[k][a] + s * V[k][b], c * V[k][b] - s * V[k][a]
            for k in range(3):
                M[a][k], M[b][k] = c * M[a][k] + s * M[b][k], c * M[b][k] - s * M[a][k]
    return [(M[k][k], [V[0][k], V[1][k], V[2][k]]) for k in range(3)]


def directions_libres(A, seuil=0.01):
    return [v for force, v in jacobi(A) if force < seuil]


def pas_droite(A, g, seuil=0.01):
    pas = [0.0, 0.0, 0.0]
    for force, v in jacobi(A):
        if force >= seuil:
            m = sum(a * b for a, b in zip(v, g)) / force
            pas = [p - m * a for p, a in zip(pas, v)]
    return pas
