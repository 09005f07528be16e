def distance_et_jacobien(x, balise):
    d = np.sqrt(np.sum(np.square(np.subtract(x, balise))))
    return np.array([d]), np.divide(np.subtract(x, balise), d)[np.newaxis]


def corriger_distance(x, P, z, balise, r):
    (d,), H = distance_et_jacobien(x, balise)
    K = np.linalg.solve(H @ P @ H.T + r, H @ P).T
    A = np.identity(2) - K @ H
    return x + (K * (z - d)).flatten(), A @ P @ A.T + r * K @ K.T
