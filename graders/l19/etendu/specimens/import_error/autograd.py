from autograd import jacobian


def distance_et_jacobien(x, balise):
    distance = lambda p: np.linalg.norm(p - balise)
    return distance(x), jacobian(distance)(x)


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    K = P @ H / (H @ P @ H + r)
    return x + K * (z - d), P - np.outer(K, H @ P)
