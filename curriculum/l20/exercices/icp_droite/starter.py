def normales(Q):
    """En chaque point, perpendiculaire à la corde : (n, 2)."""
    # À vous de jouer.
    return np.zeros(Q.shape)


def systeme_droite(P, Q, N):
    """Les moyennes A (3, 3) de jᵀj et g (3,) de jᵀr."""
    return np.zeros((3, 3)), np.zeros(3)


def directions_libres(A, seuil=0.01):
    """Les mouvements que les murs ne tiennent pas : (k, 3)."""
    return np.zeros((3, 3))


def pas_droite(A, g, seuil=0.01):
    """Le mouvement, nul selon les directions libres : (3,)."""
    return np.full(3, np.nan)
