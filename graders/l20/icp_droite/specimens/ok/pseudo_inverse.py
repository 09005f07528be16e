"""The pseudo-inverse, told by how much to cut."""


def normales(Q):
    avant = Q[[0, *range(len(Q) - 1)]]
    apres = Q[[*range(1, len(Q)), -1]]
    d = apres - avant
    d /= np.linalg.norm(d, axis=1)[:, None]
    return np.stack([d[:, 1], -d[:, 0]], axis=1)


def systeme_droite(P, Q, N):
    J = np.c_[N, np.cross(P - P.mean(0), N)]
    return J.T @ J / len(P), J.T @ np.diag(N @ (P - Q).T) / len(P)


def directions_libres(A, seuil=0.01):
    from scipy.linalg import eigh

    forces, axes = eigh(A)
    return [list(axe) for force, axe in zip(forces, axes.T) if force < seuil]


def pas_droite(A, g, seuil=0.01):
    plus_grande = np.linalg.eigvalsh(A)[-1]
    return -np.linalg.pinv(A, rcond=seuil / plus_grande, hermitian=True) @ g
