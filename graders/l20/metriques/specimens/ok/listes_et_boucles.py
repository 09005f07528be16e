"""Plain Python: loops, lists, math; the angle of the plane in closed form."""
import math


def moyenne(valeurs):
    valeurs = list(valeurs)
    return sum(valeurs) / len(valeurs)


def ate(estimees, verite):
    P, Q = estimees.tolist(), verite.tolist()
    px, py = moyenne(p[0] for p in P), moyenne(p[1] for p in P)
    qx, qy = moyenne(q[0] for q in Q), moyenne(q[1] for q in Q)
    c = s = 0.0
    for p, q in zip(P, Q):
        ax, ay, bx, by = p[0] - px, p[1] - py, q[0] - qx, q[1] - qy
        c += ax * bx + ay * by
        s += ax * by - ay * bx
    angle = math.atan2(s, c)
    total = 0.0
    for p, q in zip(P, Q):
        ax, ay = p[0] - px, p[1] - py
        x = math.cos(angle) * ax - math.sin(angle) * ay + qx
        y = math.sin(angle) * ax + math.cos(angle) * ay + qy
        total += (x - q[0]) ** 2 + (y - q[1]) ** 2
    return math.sqrt(total / len(P))


def rpe(estimees, verite, delta):
    def vu(a, b):
        dx, dy = b[0] - a[0], b[1] - a[1]
        return math.cos(a[2]) * dx + math.sin(a[2]) * dy, -math.sin(a[2]) * dx + math.cos(a[2]) * dy

    E, V = estimees.tolist(), verite.tolist()
    carres = []
    for i in range(len(V) - delta):
        (x1, y1), (x2, y2) = vu(E[i], E[i + delta]), vu(V[i], V[i + delta])
        carres.append((x1 - x2) ** 2 + (y1 - y2) ** 2)
    return math.sqrt(sum(carres) / len(carres))
