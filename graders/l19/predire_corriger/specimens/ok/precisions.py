"""Information form: precisions add up, and each opinion weighs its own."""


def predire(m, v, u, q):
    return np.array([m, v]) + np.array([u, q])


def corriger(m, v, z, r):
    precisions = np.array([1 / v, 1 / r])
    variance = 1 / precisions.sum()
    return np.array([variance * (precisions @ [m, z]), variance])
