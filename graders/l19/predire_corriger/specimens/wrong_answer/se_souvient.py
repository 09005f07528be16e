"""Keeps its own belief in globals, and no longer looks at what it is given."""
croyance = []


def predire(m, v, u, q):
    global croyance
    m, v = croyance or (m, v)
    croyance = [m + u, v + q]
    return tuple(croyance)


def corriger(m, v, z, r):
    global croyance
    m, v = croyance or (m, v)
    K = v / (v + r)
    croyance = [m + K * (z - m), (1 - K) * v]
    return tuple(croyance)
