"""One step of Gauss-Newton on the prediction and the linearised reading."""


def distance_et_jacobien(x, balise):
    d = np.sqrt(sum((a - b) ** 2 for a, b in zip(x, balise)))
    return d, [(a - b) / d for a, b in zip(x, balise)]


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    L = np.linalg.inv(np.linalg.cholesky(P))
    A = np.vstack([L, np.array(H) / np.sqrt(r)])
    b = np.array([0.0, 0.0, (z - d) / np.sqrt(r)])
    pas, *_ = np.linalg.lstsq(A, b, rcond=None)
    return x + pas, np.linalg.inv(A.T @ A)
