def distance_et_jacobien(x, balise):
    H = x.copy()
    H -= balise
    d = np.sqrt(H @ H)
    H /= d
    return d, H


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise)
    x, P = x.copy(), P.copy()
    K = P @ H
    K /= H @ K + r
    x += K * (z - d)
    P -= np.outer(K, H @ P)
    return x.tolist(), P.tolist()
