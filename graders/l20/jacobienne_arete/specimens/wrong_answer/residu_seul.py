"""The first function alone is written."""


def residu(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    a = xj[2] - xi[2] - z[2]
    return np.array([c * dx + s * dy - z[0], c * dy - s * dx - z[1], np.arctan2(np.sin(a), np.cos(a))])


def jacobiennes(xi, xj, z):
    return np.eye(3), np.eye(3)


def contribution(xi, xj, z, omega):
    return np.eye(6), np.zeros(6)
