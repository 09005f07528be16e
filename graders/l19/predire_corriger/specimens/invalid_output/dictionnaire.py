def predire(m, v, u, q):
    return {"m": m + u, "v": v + q}


def corriger(m, v, z, r):
    K = v / (v + r)
    return {"m": m + K * (z - m), "v": (1 - K) * v}
