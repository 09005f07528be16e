def normales(Q):
    return np.zeros(Q.shape


def systeme_droite(P, Q, N):
    return np.eye(3), np.zeros(3)


def directions_libres(A, seuil=0.01):
    return []


def pas_droite(A, g, seuil=0.01):
    return np.zeros(3)
