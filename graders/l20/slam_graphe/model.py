def ramener(angle):
    return np.pi - (np.pi - angle) % (2 * np.pi)


def erreur(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    u = c * dx + s * dy - z[0]
    v = -s * dx + c * dy - z[1]
    return np.array([u, v, ramener(xj[2] - xi[2] - z[2])])


def jacobiennes(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    A = np.array([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0, 0, -1.0]])
    B = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    return A, B


def gauss_newton(poses, aretes, n_iter=10):
    x = np.array(poses, dtype=float)
    n = len(x)
    for _ in range(n_iter):
        H, b = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
        for i, j, z, omega in aretes:
            e = erreur(x[i], x[j], z)
            A, B = jacobiennes(x[i], x[j], z)
            I, J = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
            H[I, I] += A.T @ omega @ A
            H[I, J] += A.T @ omega @ B
            H[J, I] += B.T @ omega @ A
            H[J, J] += B.T @ omega @ B
            b[I] += A.T @ omega @ e
            b[J] += B.T @ omega @ e
        pas = np.zeros(3 * n)
        pas[3:] = np.linalg.solve(H[3:, 3:], -b[3:])
        x = x + pas.reshape(n, 3)
        x[:, 2] = ramener(x[:, 2])
    return x
