def normales(Q):
    d = Q[1:] - Q[:-1]


def systeme_droite(P, Q, N):
    print(P - Q)


def directions_libres(A, seuil=0.01):
    np.linalg.eigh(A)


def pas_droite(A, g, seuil=0.01):
    np.linalg.eigh(A)
