"""No direction is ever free: the system is solved as it is."""


def normales(Q):
    d = np.vstack([Q[1:], Q[-1:]]) - np.vstack([Q[:1], Q[:-1]])
    return np.column_stack([-d[:, 1], d[:, 0]]) / np.linalg.norm(d, axis=1)[:, None]


def systeme_droite(P, Q, N):
    a = P - P.mean(axis=0)
    J = np.column_stack([N, N[:, 1] * a[:, 0] - N[:, 0] * a[:, 1]])
    return J.T @ J / len(P), J.T @ np.sum(N * (P - Q), axis=1) / len(P)


def directions_libres(A, seuil=0.01):
    return np.zeros((0, 3))


def pas_droite(A, g, seuil=0.01):
    return -np.linalg.lstsq(A, g, rcond=None)[0]
