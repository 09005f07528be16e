def avance(pas):
    return pas[:, 0] * np.cos(pas[:, 2] / 2


def etalonner(pas, vrais):
    return 1.0, 1.0, 0.0


def corriger(pas, gamma, beta, alpha):
    return pas
