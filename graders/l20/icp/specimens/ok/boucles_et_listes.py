"""Plain loops over lists, the angle by atan2; errors paired anew after each move."""
from math import atan2, cos, sin


def proche(x, y, Q):
    return min(range(len(Q)), key=lambda j: (Q[j][0] - x) ** 2 + (Q[j][1] - y) ** 2)


def icp(P, Q, R0, t0, n_iter=30):
    P, Q = P.tolist(), Q.tolist()
    a = atan2(R0[1][0], R0[0][0])
    tx, ty = float(t0[0]), float(t0[1])
    n = len(P)

    def bouger():
        return [(cos(a) * x - sin(a) * y + tx, sin(a) * x + cos(a) * y + ty) for x, y in P]

    def erreur():
        return sum(min((u - x) ** 2 + (v - y) ** 2 for u, v in Q) for x, y in bouger())

    erreurs = [erreur()]
    for _ in range(n_iter):
        R = [Q[proche(x, y, Q)] for x, y in bouger()]
        px, py = sum(x for x, _ in P) / n, sum(y for _, y in P) / n
        qx, qy = sum(x for x, _ in R) / n, sum(y for _, y in R) / n
        s = sum((x - px) * (v - qy) - (y - py) * (u - qx) for (x, y), (u, v) in zip(P, R))
        c = sum((x - px) * (u - qx) + (y - py) * (v - qy) for (x, y), (u, v) in zip(P, R))
        a = atan2(s, c)
        tx, ty = qx - cos(a) * px + sin(a) * py, qy - sin(a) * px - cos(a) * py
        erreurs.append(erreur())
    return ((cos(a), -sin(a)), (sin(a), cos(a))), (tx, ty), tuple(erreurs)
