def predire(m, v, u, q):
    m1 = m + u
    v1 = v + q
    return m1, v1


def corriger(m, v, z, r):
    K = v / (v + r)
    m2 = m + K * (z - m)
    v2 = (1 - K) * v
    return m2, v2
