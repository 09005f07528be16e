"""In the axes of the beacon the filter is scalar: turned, corrected, turned back."""


def distance_et_jacobien(x, balise):
    v = x - balise
    d = max(np.linalg.norm(v), 1e-300)
    return d, v / d


def corriger_distance(x, P, z, balise, r):
    d, (c, s) = distance_et_jacobien(x, balise)
    T = np.array([[c, s], [-s, c]])
    Q = T @ P @ T.T
    gain = Q[:, 0] / (Q[0, 0] + r)
    Q = Q - gain[:, None] * Q[0]
    return x + T.T @ gain * (z - d), T.T @ Q @ T
