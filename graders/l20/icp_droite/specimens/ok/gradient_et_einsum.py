def normales(Q):
    cordes = np.empty(Q.shape)
    cordes[1:-1] = Q[2:] - Q[:-2]
    cordes[0], cordes[-1] = Q[1] - Q[0], Q[-1] - Q[-2]
    tournees = cordes @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    return tournees / np.sqrt(np.einsum("ki,ki->k", tournees, tournees))[:, np.newaxis]


def systeme_droite(P, Q, N):
    a = P - np.average(P, axis=0)
    J = np.hstack([N, np.einsum("ki,ij,kj->k", a, [[0, 1], [-1, 0]], N)[:, None]])
    r = np.einsum("ki,ki->k", N, P - Q)
    return np.einsum("ki,kj->ij", J, J) / len(J), np.einsum("ki,k->i", J, r) / len(J)


def directions_libres(A, seuil=0.01):
    U, forces, _ = np.linalg.svd(A)
    return U.T[forces < seuil]


def pas_droite(A, g, seuil=0.01):
    U, forces, Vt = np.linalg.svd(A)
    inverse = np.where(forces < seuil, 0.0, 1.0 / np.maximum(forces, 1e-300))
    return -(Vt.T * inverse) @ U.T @ g
