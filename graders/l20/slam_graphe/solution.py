def ramener(angle):
    """Ramène un angle, ou un tableau d'angles, dans l'intervalle ]−π, π]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def relatif(a, b):
    """La pose b vue depuis a."""
    c, s = np.cos(a[2]), np.sin(a[2])
    dx, dy = b[0] - a[0], b[1] - a[1]
    return np.array([c * dx + s * dy, -s * dx + c * dy, ramener(b[2] - a[2])])


def erreur(xi, xj, z):
    """Ce que les poses disent, moins ce que la mesure disait."""
    e = relatif(xi, xj) - z
    # La différence de deux angles ramenés peut encore dépasser un demi-tour.
    e[2] = ramener(e[2])
    return e


def jacobiennes(xi, xj):
    """Dérivées de l'erreur par rapport à xi, puis par rapport à xj : deux tableaux 3 × 3."""
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    # La troisième colonne dit ce que voit i quand il pivote : j se décale sur le côté.
    par_xi = [[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0.0, 0.0, -1.0]]
    par_xj = [[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]]
    return par_xi, par_xj


def lineariser(poses, aretes):
    """Empile les arêtes : l'erreur e (3m,), sa jacobienne J (3m, 3n), et les poids W (3m, 3m)."""
    n, m = len(poses), len(aretes)
    e, J, W = np.zeros(3 * m), np.zeros((3 * m, 3 * n)), np.zeros((3 * m, 3 * m))
    for k, (i, j, z, omega) in enumerate(aretes):
        lignes = slice(3 * k, 3 * k + 3)
        e[lignes] = erreur(poses[i], poses[j], z)
        # Une arête ne touche que deux poses : tout le reste de ces trois lignes de J est nul.
        J[lignes, 3 * i : 3 * i + 3], J[lignes, 3 * j : 3 * j + 3] = jacobiennes(poses[i], poses[j])
        W[lignes, lignes] = omega
    return e, J, W


def correction(e, J, W):
    """Résout (JᵀΩJ) Δ = −JᵀΩe sans toucher à la première pose ; renvoie Δ, une ligne par pose."""
    H = J.T @ W @ J
    b = J.T @ W @ e
    delta = np.zeros(len(b))
    # Déplacer tout le graphe d'un bloc ne change aucune erreur : H n'est inversible qu'une fois la première pose fixée.
    delta[3:] = np.linalg.solve(H[3:, 3:], -b[3:])
    return delta.reshape(-1, 3)


def corriger(poses, delta):
    """Ajoute la correction ; un cap qui passe le demi-tour est ramené."""
    x = poses + delta
    x[:, 2] = ramener(x[:, 2])
    return x


def gauss_newton(poses, aretes, n_iter=10):
    """Les poses qui rendent Σ eᵀΩe minimale, en partant de celles qui sont données."""
    x = np.array(poses, dtype=float)  # une copie : le tableau reçu reste intact
    for _ in range(n_iter):
        # La linéarisation n'est bonne que près de x : on la refait à chaque tour.
        delta = correction(*lineariser(x, aretes))
        x = corriger(x, delta)
        if np.max(np.abs(delta)) < 1e-10:
            break  # plus rien ne bouge : continuer ne servirait à rien
    return x
