def ramener(angle):
    return np.pi - (np.pi - angle) % (2 * np.pi)


def erreur_pose(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    u = c * dx + s * dy - z[0]
    v = -s * dx + c * dy - z[1]
    return np.array([u, v, ramener(xj[2] - xi[2] - z[2])])


def jacobiennes_pose(xi, xj):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    A = np.array([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0, 0, -1.0]])
    B = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    return A, B


def erreur_amer(x, a, z):
    c, s = np.cos(x[2]), np.sin(x[2])
    dx, dy = a[0] - x[0], a[1] - x[1]
    return np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1]])


def jacobiennes_amer(x, a):
    c, s = np.cos(x[2]), np.sin(x[2])
    dx, dy = a[0] - x[0], a[1] - x[1]
    A = np.array([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy]])
    B = np.array([[c, s], [-s, c]])
    return A, B


def ajouter(H, b, I, J, A, B, omega, e):
    H[I, I] += A.T @ omega @ A
    H[I, J] += A.T @ omega @ B
    H[J, I] += B.T @ omega @ A
    H[J, J] += B.T @ omega @ B
    b[I] += A.T @ omega @ e
    b[J] += B.T @ omega @ e


def systeme(poses, amers, aretes, observations):
    n, m = len(poses), len(amers)
    taille = 3 * n + 2 * m
    H, b = np.zeros((taille, taille)), np.zeros(taille)
    for i, j, z, omega in aretes:
        A, B = jacobiennes_pose(poses[i], poses[j])
        e = erreur_pose(poses[i], poses[j], z)
        I, J = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
        ajouter(H, b, I, J, A, B, omega, e)
    for i, j, z, omega in observations:
        A, B = jacobiennes_amer(poses[i], amers[j])
        e = erreur_amer(poses[i], amers[j], z)
        I, J = slice(3 * i, 3 * i + 3), slice(3 * n + 2 * j, 3 * n + 2 * j + 2)
        ajouter(H, b, I, J, A, B, omega, e)
    return H, b


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    x, a = np.array(poses, dtype=float), np.array(amers, dtype=float)
    n, m = len(x), len(a)
    for _ in range(n_iter):
        H, b = systeme(x, a, aretes, observations)
        pas = np.zeros(3 * n + 2 * m)
        pas[3:] = np.linalg.solve(H[3:, 3:], -b[3:])
        x = x + pas[: 3 * n].reshape(n, 3)
        a = a + pas[3 * n :].reshape(m, 2)
        x[:, 2] = ramener(x[:, 2])
    return x, a
