"""Half angles, as quaternions have them; closures; a 0-d array."""
import math


def moitie(theta):
    return math.cos(theta / 2), math.sin(theta / 2)


def tourner(q, v):
    w, z = q
    return [(w * w - z * z) * v[0] - 2 * w * z * v[1], 2 * w * z * v[0] + (w * w - z * z) * v[1]]


def vu_depuis(a):
    w, z = moitie(a[2])

    def voir(b):
        return tourner((w, -z), [b[0] - a[0], b[1] - a[1]])

    return voir


def ate(estimees, verite):
    n = len(estimees)
    cp, cq = [sum(col) / n for col in zip(*estimees)], [sum(col) / n for col in zip(*verite)]
    s = c = 0
    for p, q in zip(estimees, verite):
        u, v = (p[0] - cp[0], p[1] - cp[1]), (q[0] - cq[0], q[1] - cq[1])
        c, s = c + u[0] * v[0] + u[1] * v[1], s + u[0] * v[1] - u[1] * v[0]
    q0 = moitie(math.atan2(s, c))
    carre = 0
    for p, q in zip(estimees, verite):
        x, y = tourner(q0, [p[0] - cp[0], p[1] - cp[1]])
        carre += (x + cq[0] - q[0]) ** 2 + (y + cq[1] - q[1]) ** 2
    return np.asarray(math.sqrt(carre / n))


def rpe(estimees, verite, delta):
    distances = [
        math.dist(vu_depuis(estimees[i])(estimees[i + delta]), vu_depuis(verite[i])(verite[i + delta]))
        for i in range(len(estimees) - delta)
    ]
    return math.sqrt(math.fsum(d * d for d in distances) / len(distances))
