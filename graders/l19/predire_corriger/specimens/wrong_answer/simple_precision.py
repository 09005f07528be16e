def predire(m, v, u, q):
    return np.float32(m) + np.float32(u), np.float32(v) + np.float32(q)


def corriger(m, v, z, r):
    m, v, z, r = np.array([m, v, z, r], dtype=np.float32)
    K = v / (v + r)
    return m + K * (z - m), (1 - K) * v
