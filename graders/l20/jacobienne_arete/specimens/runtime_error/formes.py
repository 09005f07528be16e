def residu(xi, xj, z):
    R = np.array([[np.cos(xi[2]), -np.sin(xi[2])], [np.sin(xi[2]), np.cos(xi[2])]])
    return R.T @ (xj - xi) - z


def jacobiennes(xi, xj, z):
    R = np.array([[np.cos(xi[2]), -np.sin(xi[2])], [np.sin(xi[2]), np.cos(xi[2])]])
    return np.hstack([-R.T, R @ (xj - xi)]), np.eye(3)


def contribution(xi, xj, z, omega):
    A, B = jacobiennes(xi, xj, z)
    return A @ omega @ B, A @ omega
