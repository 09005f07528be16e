def predire(m, v, u, q):
    print(m + u, v + q)


def corriger(m, v, z, r):
    K = v / (v + r)
    print(m + K * (z - m), (1 - K) * v)
