def distance_et_jacobien(x, balise):
    ecart = x - balise
    d = np.sqrt(ecart[0] ** 2 + ecart[1] ** 2)
    H = ecart / d
    return d, H


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    S = H @ P @ H + r
    K = P @ H / S
    x2 = x + K * (z - d)
    P2 = P - np.outer(K, H @ P)
    return x2, P2
