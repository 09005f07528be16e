def normales(Q):
    """En chaque point, la direction perpendiculaire à la corde de ses deux voisins."""
    # Au bout du mur, le point lui-même remplace le voisin qui manque.
    avant = np.vstack([Q[:1], Q[:-1]])
    apres = np.vstack([Q[1:], Q[-1:]])
    u, v = (apres - avant).T
    return np.column_stack([-v, u]) / np.hypot(u, v)[:, None]


def systeme_droite(P, Q, N):
    """Les écarts en travers des murs, et ce que leur fait un petit mouvement, résumés en A et g."""
    a = P - P.mean(axis=0)
    J = np.column_stack([N, N[:, 1] * a[:, 0] - N[:, 0] * a[:, 1]])
    r = np.sum(N * (P - Q), axis=1)
    return J.T @ J / len(P), J.T @ r / len(P)


def directions_libres(A, seuil=0.01):
    """Les mouvements qui ne changent presque rien aux écarts."""
    forces, axes = np.linalg.eigh(A)
    return axes[:, forces < seuil].T


def pas_droite(A, g, seuil=0.01):
    """Le pas de moindres carrés, sans bouger là où rien n'est vu."""
    forces, axes = np.linalg.eigh(A)
    pas = np.zeros(3)
    for force, axe in zip(forces, axes.T):
        if force >= seuil:
            pas -= (axe @ g) / force * axe
    return pas
