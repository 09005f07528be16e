"""Information form: H Hᵀ / r is added to the inverse of P."""


def distance_et_jacobien(x, balise):
    ecart = x - balise
    d = ecart.dot(ecart) ** 0.5
    return d, ecart / d


def corriger_distance(x, P, z, balise, r):
    d, h = distance_et_jacobien(x, balise)
    apres = np.linalg.inv(np.linalg.inv(P) + np.outer(h, h) / r)
    return x + apres @ h * (z - d) / r, apres
