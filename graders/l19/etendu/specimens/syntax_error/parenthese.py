def distance_et_jacobien(x, balise):
    d = np.sqrt((x[0] - balise[0]) ** 2 + (x[1] - balise[1] ** 2)
    return d, (x - balise) / d


def corriger_distance(x, P, z, balise, r):
    return x, P
