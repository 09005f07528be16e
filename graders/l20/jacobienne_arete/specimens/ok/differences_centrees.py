def residu(xi, xj, z):
    R = np.array([[np.cos(xi[2]), -np.sin(xi[2])], [np.sin(xi[2]), np.cos(xi[2])]])
    e = np.zeros(3)
    e[:2] = R.T @ (xj[:2] - xi[:2]) - z[:2]
    e[2] = (xj[2] - xi[2] - z[2] + np.pi) % (2 * np.pi) - np.pi
    return e


def jacobiennes(xi, xj, z, h=1e-4):
    I = h * np.eye(3)
    A = np.stack([(residu(xi + d, xj, z) - residu(xi - d, xj, z)) / (2 * h) for d in I]).T
    B = np.stack([(residu(xi, xj + d, z) - residu(xi, xj - d, z)) / (2 * h) for d in I]).T
    return [A, B]


def contribution(xi, xj, z, omega):
    J = np.hstack(jacobiennes(xi, xj, z))
    return [J.T.dot(omega).dot(J), J.T.dot(omega).dot(residu(xi, xj, z))]
