def distance_et_jacobien(x, balise):
    d = np.linalg.norm(x - balise)
    return {"d": d, "H": (x - balise) / d}


def corriger_distance(x, P, z, balise, r):
    d, H = distance_et_jacobien(x, balise).values()
    K = P @ H / (H @ P @ H + r)
    return {"x": x + K * (z - d), "P": P - np.outer(K, H @ P)}
