def residu(xi, xj, z)
    return xj - xi - z


def jacobiennes(xi, xj, z):
    return -np.eye(3), np.eye(3)


def contribution(xi, xj, z, omega):
    return np.eye(6), np.zeros(6)
