def predire(m, v, u, q):
    return m + u, v + Q


def corriger(m, v, z, r):
    K = v / (v + r)
    return m + K * (z - m), (1 - k) * v
