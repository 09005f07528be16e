"""The problem is written in the held directions, solved there, and brought back."""


def normales(Q):
    u, v = np.gradient(Q[:, 0]), np.gradient(Q[:, 1])
    longueur = np.hypot(u, v)
    return np.column_stack([-v / longueur, u / longueur])


def systeme_droite(P, Q, N):
    n = P.shape[0]
    centre = np.add.reduce(P) / n
    tour = np.array([m[1] * (p[0] - centre[0]) - m[0] * (p[1] - centre[1]) for p, m in zip(P, N)])
    J = np.vstack([N.T, tour])
    return (J @ J.T) / n, (J @ ((P - Q) * N).sum(axis=1)) / n


def decoupe(A, seuil):
    forces, axes = np.linalg.eigh(A)
    return axes[:, forces < seuil], axes[:, forces >= seuil]


def directions_libres(A, seuil=0.01):
    return decoupe(A, seuil)[0].T


def pas_droite(A, g, seuil=0.01):
    V = decoupe(A, seuil)[1]
    return -V @ np.linalg.solve(V.T @ A @ V, V.T @ g)
