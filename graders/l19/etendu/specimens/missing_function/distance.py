def distance(x, balise):
    return np.linalg.norm(x - balise)


def corriger(x, P, z, balise, r):
    H = (x - balise) / distance(x, balise)
    K = P @ H / (H @ P @ H + r)
    return x + K * (z - distance(x, balise)), P - np.outer(K, H @ P)
