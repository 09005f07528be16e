"""Right values, but the state and the covariance are changed in place."""


def distance_et_jacobien(x, balise):
    d = np.linalg.norm(x - balise)
    return d, (x - balise) / d


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    K = P @ H / (H @ P @ H + r)
    P -= np.outer(K, H @ P)
    x += K * (z - d)
    return x, P
