"""The robot is thought to be right."""


def avance(pas):
    return np.hypot(pas[:, 0], pas[:, 1])


def etalonner(pas, vrais):
    return 1.0, 1.0, 0.0


def corriger(pas, gamma, beta, alpha):
    return pas.copy()
