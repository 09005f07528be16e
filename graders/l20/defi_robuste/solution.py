def ramener(angle):
    """Ramène un angle, ou un tableau d'angles, dans l'intervalle ]−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def arete(xi, xj, z):
    """L'erreur (3,) d'une arête, et ses dérivées par rapport à xi et à xj (3 × 3)."""
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    e = np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], ramener(xj[2] - xi[2] - z[2])])
    par_xi = np.array([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0.0, 0.0, -1.0]])
    par_xj = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return e, par_xi, par_xj


def systeme(poses, aretes, poids):
    """H et b, sans rien fixer, où chaque arête compte pour son poids."""
    taille = 3 * len(poses)
    H, b = np.zeros((taille, taille)), np.zeros(taille)
    for (i, j, z, omega), w in zip(aretes, poids, strict=True):
        e, par_xi, par_xj = arete(poses[i], poses[j], z)
        J = np.zeros((3, taille))
        J[:, 3 * i : 3 * i + 3], J[:, 3 * j : 3 * j + 3] = par_xi, par_xj
        # Le poids multiplie l'information : dans H et dans b, ou le pas mélange deux problèmes.
        H += J.T @ (w * omega) @ J
        b += J.T @ (w * omega) @ e
    return H, b


def ponderer(poses, aretes, delta):
    """Les poids de Huber, min(1, delta / erreur) : 1 tant que l'erreur blanchie ne dépasse pas delta."""
    normes = []
    for i, j, z, omega in aretes:
        e = arete(poses[i], poses[j], z)[0]
        normes.append(np.sqrt(e @ omega @ e))  # en écarts-types, pas en mètres
    return delta / np.maximum(normes, delta)


def dimension_noyau(poses, aretes):
    """Le nombre de valeurs propres nulles de H : trois par morceau du graphe."""
    H, _ = systeme(poses, aretes, np.ones(len(aretes)))
    valeurs = np.linalg.eigvalsh(H)
    # Les valeurs nulles ne le sont qu'aux arrondis près : on les compare à la plus grande.
    return np.sum(valeurs < 1e-8 * valeurs.max())


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    """Gauss-Newton où les poids sont recalculés à chaque tour ; la première pose ne bouge pas."""
    x = np.array(poses, dtype=float)  # une copie : le tableau reçu reste intact
    for _ in range(n_iter):
        H, b = systeme(x, aretes, ponderer(x, aretes, delta))
        pas = np.zeros(len(b))
        pas[3:] = np.linalg.solve(H[3:, 3:], -b[3:])
        x += pas.reshape(x.shape)
        x[:, 2] = ramener(x[:, 2])
    # Les poids renvoyés sont ceux des poses finales.
    return x, ponderer(x, aretes, delta)
