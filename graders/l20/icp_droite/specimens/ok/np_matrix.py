def normales(Q):
    M = np.matrix(Q)
    D = np.matrix(np.zeros((len(Q), len(Q))))
    for k in range(len(Q)):
        D[k, min(k + 1, len(Q) - 1)] += 1
        D[k, max(k - 1, 0)] -= 1
    C = D * M * np.matrix([[0, 1], [-1, 0]])
    return C / np.sqrt(np.power(C, 2).sum(axis=1))


def systeme_droite(P, Q, N):
    a = P - P.mean(axis=0)
    J = np.matrix(np.column_stack((N, a[:, 0] * N[:, 1] - a[:, 1] * N[:, 0])))
    r = np.matrix(((P - Q) * N).sum(axis=1)).T
    return J.T * J / len(P), np.asarray(J.T * r / len(P)).ravel()


def directions_libres(A, seuil=0.01):
    forces, axes = np.linalg.eigh(np.matrix(A))
    return axes.T[np.where(forces < seuil)[0]]


def pas_droite(A, g, seuil=0.01):
    forces, axes = np.linalg.eigh(np.matrix(A))
    D = np.matrix(np.diag([0 if f < seuil else 1 / f for f in forces]))
    return np.asarray(-axes * D * axes.T * np.matrix(g).T).ravel()
