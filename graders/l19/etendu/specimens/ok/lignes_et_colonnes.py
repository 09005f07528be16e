"""H as a row (1, 2), states as columns, the general formula of the filter."""


def distance_et_jacobien(x, balise):
    d = np.linalg.norm(x - balise)
    return d, (x - balise).reshape(1, 2) / d


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    S = H @ P @ H.T + np.array([[r]])
    K = P @ H.T @ np.linalg.inv(S)
    x = x[:, None] + K @ np.array([[z - d]])
    return x.ravel(), (np.eye(2) - K @ H) @ P
