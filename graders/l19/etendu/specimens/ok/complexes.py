"""The plane as complex numbers."""


def distance_et_jacobien(x, balise):
    ecart = complex(*x) - complex(*balise)
    direction = ecart / abs(ecart)
    return abs(ecart), np.array([direction.real, direction.imag])


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    K = P.dot(H) / (H.dot(P).dot(H) + r)
    return x + K * (z - d), P - K[:, None] * (H @ P)[None, :]
