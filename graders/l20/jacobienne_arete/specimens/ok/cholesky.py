"""The weight as a product: H = (L'J)'(L'J)."""


def residu(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    Rt = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    e = Rt @ (xj - xi) - z
    e[2] = np.remainder(e[2] + np.pi, 2 * np.pi) - np.pi
    return e


def jacobiennes(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    Rt = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    derivee = np.array([[-s, c, 0], [-c, -s, 0], [0, 0, 0]])
    A = -Rt
    A[:, 2] += derivee @ (xj - xi)
    return A, Rt


def contribution(xi, xj, z, omega):
    L = np.linalg.cholesky(omega)
    J = L.T @ np.hstack(jacobiennes(xi, xj, z))
    return J.T @ J, J.T @ (L.T @ residu(xi, xj, z))
