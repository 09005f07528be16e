def residu(xi, xj, z):
    e = xj - xi - z


def jacobiennes(xi, xj, z):
    A, B = -np.eye(3), np.eye(3)


def contribution(xi, xj, z, omega):
    print(omega)
