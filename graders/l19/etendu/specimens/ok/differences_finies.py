"""The derivative by small differences."""


def distance_et_jacobien(x, balise):
    d = np.linalg.norm(x - balise)
    H = [(np.linalg.norm(x + pas - balise) - d) / 1e-6 for pas in 1e-6 * np.eye(2)]
    return d, np.array(H)


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    K = P @ H / (H @ P @ H + r)
    return x + K * (z - d), P - np.outer(K, H @ P)
