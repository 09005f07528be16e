"""A number has no inverse by np.linalg.inv."""


def distance_et_jacobien(x, balise):
    ecart = x - balise
    return math.sqrt(ecart @ ecart), ecart / math.sqrt(ecart @ ecart)


def corriger_distance(x, P, z, balise, r):
    ecart = x - balise
    H = ecart / np.linalg.norm(ecart)
    K = P @ H @ np.linalg.inv(H @ P @ H + r)
    return x + K * (z - np.linalg.norm(ecart)), P - np.outer(K, H @ P)
