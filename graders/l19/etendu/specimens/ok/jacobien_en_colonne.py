"""The Jacobian as a column, as K is."""
def distance_et_jacobien(x, balise):
    ecart = np.reshape(x, (2, 1)) - np.reshape(balise, (2, 1))
    d = np.linalg.norm(ecart)
    return d, ecart / d


def corriger_distance(x, P, z, balise, r):
    d, colonne = distance_et_jacobien(x, balise)
    PH = P @ colonne
    S = (colonne.T @ PH).item() + r
    K = PH / S
    return x + K[:, 0] * (z - d), P - K @ PH.T
