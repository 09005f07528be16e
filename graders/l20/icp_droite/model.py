def normales(Q):
    avant = np.vstack([Q[:1], Q[:-1]])
    apres = np.vstack([Q[1:], Q[-1:]])
    corde = apres - avant
    travers = np.column_stack([-corde[:, 1], corde[:, 0]])
    return travers / np.linalg.norm(travers, axis=1, keepdims=True)


def systeme_droite(P, Q, N):
    centre = P.mean(axis=0)
    bras = P - centre
    tour = N[:, 1] * bras[:, 0] - N[:, 0] * bras[:, 1]
    J = np.column_stack([N, tour])
    r = np.sum(N * (P - Q), axis=1)
    A = J.T @ J / len(P)
    g = J.T @ r / len(P)
    return A, g


def directions_libres(A, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    libres = forces < seuil
    return axes[:, libres].T


def pas_droite(A, g, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    tenues = forces >= seuil
    V = axes[:, tenues]
    return -V @ ((V.T @ g) / forces[tenues])
