"""Right values, but the cloud given is centred."""


def normales(Q):
    d = np.vstack([Q[1:], Q[-1:]]) - np.vstack([Q[:1], Q[:-1]])
    return np.column_stack([-d[:, 1], d[:, 0]]) / np.linalg.norm(d, axis=1)[:, None]


def systeme_droite(P, Q, N):
    r = np.sum(N * (P - Q), axis=1)
    P -= P.mean(axis=0)
    J = np.column_stack([N, N[:, 1] * P[:, 0] - N[:, 0] * P[:, 1]])
    return J.T @ J / len(P), J.T @ r / len(P)


def directions_libres(A, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    return axes[:, forces < seuil].T


def pas_droite(A, g, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    V = axes[:, forces >= seuil]
    return -V @ ((V.T @ g) / forces[forces >= seuil])
