"""Points as complex numbers: a normal is a chord times i."""


def complexe(T):
    return T[:, 0] + 1j * T[:, 1]


def normales(Q):
    q = complexe(Q)
    corde = np.concatenate([[q[1] - q[0]], q[2:] - q[:-2], [q[-1] - q[-2]]])
    n = 1j * corde / abs(corde)
    return np.array([n.real, n.imag]).T


def systeme_droite(P, Q, N):
    p, q, n = complexe(P), complexe(Q), complexe(N)
    a = p - p.mean()
    J = np.array([n.real, n.imag, (n.conjugate() * 1j * a).real])
    r = (n.conjugate() * (p - q)).real
    return J @ J.T / len(p), J @ r / len(p)


def directions_libres(A, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    k = np.searchsorted(forces, seuil)
    return axes[:, :k].T


def pas_droite(A, g, seuil=0.01):
    forces, axes = np.linalg.eigh(A)
    k = int(np.searchsorted(forces, seuil))
    return -axes[:, k:] @ np.diag(1 / forces[k:]) @ axes[:, k:].T @ g
