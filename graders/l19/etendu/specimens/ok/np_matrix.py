def distance_et_jacobien(x, balise):
    ecart = np.matrix(x - balise)
    d = np.sqrt((ecart * ecart.T)[0, 0])
    return d, np.asarray(ecart / d)


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    H, P = np.matrix(H), np.matrix(P)
    K = P * H.T * (H * P * H.T + r).I
    return np.asarray(np.matrix(x).T + K * (z - d)).ravel(), np.asarray((np.matrix(np.eye(2)) - K * H) * P)
