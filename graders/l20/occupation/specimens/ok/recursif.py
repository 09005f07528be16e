"""The ray is halved until both ends are in one cell."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


import math


def couper(p, q, profondeur=0):
    a, b = (math.floor(p[1]), math.floor(p[0])), (math.floor(q[1]), math.floor(q[0]))
    if a == b:
        return {a}
    if profondeur > 9:
        return {a, b}
    m = ((p[0] + q[0]) / 2, (p[1] + q[1]) / 2)
    return couper(p, m, profondeur + 1) | couper(m, q, profondeur + 1)


def rayons(pose, scan, portee_max, k=0):
    if k == len(scan):
        return []
    x, y, theta = pose
    a, z = theta + 2 * math.pi * k / len(scan), scan[k]

    def point(d):
        return x + d * math.cos(a), y + d * math.sin(a)

    bout = point(z + 1e-6)
    mur = (math.floor(bout[1]), math.floor(bout[0])) if z < portee_max else None
    libre = couper(point(0), point(min(z, portee_max) - 1e-7)) - {mur}
    return [(libre, mur), *rayons(pose, scan, portee_max, k + 1)]


def integrer_scan(l, pose, scan, portee_max):
    l = l.copy()
    for libre, mur in rayons(pose, scan, portee_max):
        for i, j in libre:
            if 0 <= i < l.shape[0] and 0 <= j < l.shape[1]:
                l[i, j] -= 0.847
        if mur and 0 <= mur[0] < l.shape[0] and 0 <= mur[1] < l.shape[1]:
            l[mur] += 0.847
    return l.clip(-5, 5)
