"""Right values, but the pose j becomes a difference."""


def residu(xi, xj, z):
    xj -= xi
    c, s = np.cos(xi[2]), np.sin(xi[2])
    a = xj[2] - z[2]
    return np.array([c * xj[0] + s * xj[1] - z[0], c * xj[1] - s * xj[0] - z[1], np.arctan2(np.sin(a), np.cos(a))])


def jacobiennes(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    A = np.array([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0, 0, -1]])
    return A, np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])


def contribution(xi, xj, z, omega):
    J = np.hstack(jacobiennes(xi, xj, z))
    return J.T @ omega @ J, J.T @ omega @ residu(xi, xj.copy(), z)
