def normale(Q):
    return Q


def systeme(P, Q, N):
    return np.eye(3), np.zeros(3)


def direction_libre(A, seuil=0.01):
    return np.zeros((0, 3))


def pas(A, g, seuil=0.01):
    return np.zeros(3)
