"""The derivative of the gap by an imaginary step."""


def normales(Q):
    cordes = np.diff(np.pad(Q, ((1, 1), (0, 0)), mode="edge"), axis=0)
    somme = cordes[1:] + cordes[:-1]
    angle = np.arctan2(somme[:, 1], somme[:, 0]) + np.pi / 2
    return np.column_stack([np.cos(angle), np.sin(angle)])


def ecarts(mouvement, P, Q, N):
    dx, dy, t = mouvement
    c = P.mean(axis=0)
    R = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    return np.sum(N * ((P - c) @ R.T + c + np.array([dx, dy]) - Q), axis=1)


def systeme_droite(P, Q, N):
    h = 1e-40j
    J = np.column_stack([ecarts(h * u, P, Q, N).imag / 1e-40 for u in np.eye(3)])
    r = ecarts(np.zeros(3), P, Q, N)
    return J.T @ J / len(P), J.T @ r / len(P)


def directions_libres(A, seuil=0.01):
    valeurs, vecteurs = np.linalg.eig(A)
    rangs = np.flatnonzero(valeurs.real < seuil)
    if len(rangs) == 1:
        return vecteurs[:, rangs[0]].real
    return vecteurs[:, rangs].real.T


def pas_droite(A, g, seuil=0.01):
    L = np.atleast_2d(directions_libres(A, seuil)).reshape(-1, 3)
    # Bordered: as small as can be in the held directions, zero along the free ones.
    k = len(L)
    M = np.block([[A, L.T], [L, np.zeros((k, k))]])
    libre = np.eye(3) - np.linalg.pinv(L) @ L if k else np.eye(3)
    return np.linalg.lstsq(M, np.append(-libre @ g, np.zeros(k)), rcond=None)[0][:3]
