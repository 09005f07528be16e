def Residu(xi, xj, z):
    return xj - xi - z


def jacobienne(xi, xj, z):
    return -np.eye(3), np.eye(3)


def systeme(xi, xj, z, omega):
    return np.eye(6), np.zeros(6)
