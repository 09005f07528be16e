def position_vue(a, b):
    """La position de la pose b vue depuis a : l'écart, lu dans le repère de a."""
    c, s = np.cos(a[2]), np.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    return np.array([c * dx + s * dy, c * dy - s * dx])


def ate(estimees, verite):
    """L'écart quadratique moyen des positions, après le meilleur alignement rigide."""
    # L'alignement est celui de Kabsch : d'abord les deux trajectoires ramenées à leurs centres.
    P = estimees[:, :2] - estimees[:, :2].mean(axis=0)
    Q = verite[:, :2] - verite[:, :2].mean(axis=0)
    # Dans le plan, l'angle de la meilleure rotation se lit sur H, sans SVD. C'est une rotation, jamais un miroir.
    H = P.T @ Q
    angle = np.arctan2(H[0, 1] - H[1, 0], H[0, 0] + H[1, 1])
    c, s = np.cos(angle), np.sin(angle)
    # Avec une position par ligne, tourner par R s'écrit P @ R.T.
    ecarts = P @ np.array([[c, s], [-s, c]]) - Q
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
