def position_vue(a, b):
    """La position de la pose b vue depuis a : l'écart, lu dans le repère de a."""
    c, s = np.cos(a[2]), np.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    return np.array([c * dx + s * dy, c * dy - s * dx])


def ate(estimees, verite):
    """L'écart quadratique moyen des positions, après le meilleur alignement rigide."""
    # L'alignement est celui de Kabsch : les centres d'abord, puis la rotation, par une SVD.
    P = estimees[:, :2] - estimees[:, :2].mean(axis=0)
    Q = verite[:, :2] - verite[:, :2].mean(axis=0)
    U, _, Vt = np.linalg.svd(P.T @ Q)
    # Une trajectoire en miroir ne se retourne pas : on garde une rotation, de déterminant +1.
    sens = np.sign(np.linalg.det(U @ Vt))
    # Avec une position par ligne, tourner par R = V D Uᵀ s'écrit P @ R.T, et R.T = U D Vᵀ.
    ecarts = P @ U @ np.diag([1.0, sens]) @ Vt - Q
    # Le carré d'une distance réunit les deux coordonnées : une somme par ligne, puis la moyenne des lignes.
    return np.sqrt(np.mean(np.sum(ecarts**2, axis=1)))


def rpe(estimees, verite, delta):
    """L'écart quadratique moyen des déplacements entre i et i + delta."""
    carres = []
    for i in range(len(verite) - delta):
        # Chaque déplacement est lu par le robot, depuis sa pose i : le repère commun disparaît.
        estime = position_vue(estimees[i], estimees[i + delta])
        vrai = position_vue(verite[i], verite[i + delta])
        # Lire l'estimé depuis le vrai retranche l'un à l'autre, puis tourne l'écart : sa longueur n'y change pas.
        carres.append(np.sum((estime - vrai) ** 2))
    return np.sqrt(np.mean(carres))
