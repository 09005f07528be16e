def ramener(angle):
    return np.pi - (np.pi - angle) % (2 * np.pi)


def residu(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    u = c * dx + s * dy - z[0]
    v = -s * dx + c * dy - z[1]
    return np.array([u, v, ramener(xj[2] - xi[2] - z[2])])


def jacobiennes(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    cap = np.array([-s * dx + c * dy, -c * dx - s * dy, -1.0])
    depl = np.array([[c, s], [-s, c], [0.0, 0.0]])
    A = np.column_stack([-depl, cap])
    B = np.column_stack([depl, [0.0, 0.0, 1.0]])
    return A, B


def contribution(xi, xj, z, omega):
    A, B = jacobiennes(xi, xj, z)
    e = residu(xi, xj, z)
    J = np.hstack([A, B])
    H = J.T @ omega @ J
    b = J.T @ omega @ e
    return H, b
