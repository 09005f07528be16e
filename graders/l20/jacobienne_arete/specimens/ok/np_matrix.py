def residu(xi, xj, z):
    Rt = np.matrix([[np.cos(xi[2]), np.sin(xi[2])], [-np.sin(xi[2]), np.cos(xi[2])]])
    d = Rt * np.matrix(xj[:2] - xi[:2]).T - np.matrix(z[:2]).T
    a = (xj[2] - xi[2] - z[2]) % (2 * np.pi)
    return np.array([d[0, 0], d[1, 0], a if a <= np.pi else a - 2 * np.pi])


def jacobiennes(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    ex, ey = np.array([c, s]), np.array([-s, c])
    d = xj[:2] - xi[:2]
    A = np.matrix(np.zeros((3, 3)))
    A[0, :2], A[1, :2] = -ex, -ey
    A[0, 2], A[1, 2], A[2, 2] = d @ ey, -d @ ex, -1
    B = np.matrix(np.zeros((3, 3)))
    B[0, :2], B[1, :2], B[2, 2] = ex, ey, 1
    return A, B


def contribution(xi, xj, z, omega):
    A, B = jacobiennes(xi, xj, z)
    J = np.matrix(np.hstack([A, B]))
    e = np.matrix(residu(xi, xj, z)).T
    return J.T * np.matrix(omega) * J, np.asarray(J.T * np.matrix(omega) * e).ravel()
