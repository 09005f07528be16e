"""The projector on what is held; the free directions get a unit stiffness."""


def normales(Q):
    N = []
    for avant, apres in zip([Q[0], *Q[:-1]], [*Q[1:], Q[-1]]):
        d = apres - avant
        N.append(np.array([-d[1], d[0]]) / np.sqrt(d @ d))
    return np.vstack(N)


def systeme_droite(P, Q, N):
    m = len(P)
    a = (P - P.sum(axis=0) / m).T
    J = np.stack([N[:, 0], N[:, 1], a[0] * N[:, 1] - a[1] * N[:, 0]], axis=-1)
    r = N[:, 0] * (P[:, 0] - Q[:, 0]) + N[:, 1] * (P[:, 1] - Q[:, 1])
    return np.tensordot(J, J, axes=(0, 0)) / m, np.dot(r, J) / m


def directions_libres(A, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    return np.compress(forces < seuil, axes, axis=1).T


def pas_droite(A, g, seuil=0.01):
    libres = directions_libres(A, seuil)
    tenu = np.eye(3) - libres.T @ libres
    return -np.linalg.solve(tenu @ A @ tenu + libres.T @ libres, tenu @ g)
