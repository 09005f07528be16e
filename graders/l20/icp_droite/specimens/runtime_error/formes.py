"""Each function fails on its shapes."""


def normales(Q):
    return Q / np.linalg.norm(Q, axis=1)[:3, None] @ np.ones((3, 3))


def systeme_droite(P, Q, N):
    return N @ (P - Q), P @ N


def directions_libres(A, seuil=0.01):
    return np.linalg.eigh(A)[0][:, 0]


def pas_droite(A, g, seuil=0.01):
    return -np.linalg.solve(A[:2], g)
