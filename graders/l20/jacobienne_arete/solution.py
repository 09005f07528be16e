def residu(xi, xj, z):
    """La pose xj vue depuis xi, moins la mesure."""
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    angle = xj[2] - xi[2] - z[2]
    return np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], np.pi - (np.pi - angle) % (2 * np.pi)])


def jacobiennes(xi, xj, z):
    """Les dérivées du résidu par rapport à xi, puis à xj."""
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    # Déplacer j se voit dans les axes de i ; déplacer i, c'est déplacer j dans l'autre sens.
    B = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    A = -B
    # Quand i pivote, j tourne autour de lui dans l'autre sens : la dérivée de Rᵀ appliquée à l'écart.
    A[0, 2] = -s * dx + c * dy
    A[1, 2] = -c * dx - s * dy
    return A, B


def contribution(xi, xj, z, omega):
    """Ce que l'arête ajoute au système : JᵀΩJ et JᵀΩe."""
    J = np.hstack(jacobiennes(xi, xj, z))
    return J.T @ omega @ J, J.T @ omega @ residu(xi, xj, z)
