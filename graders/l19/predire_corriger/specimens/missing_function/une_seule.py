def prediction(m, v, u, q):
    return m + u, v + q


def correction(m, v, z, r):
    K = v / (v + r)
    return m + K * (z - m), (1 - K) * v
