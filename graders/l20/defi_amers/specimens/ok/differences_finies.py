def err_p(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    d = xj[:2] - xi[:2]
    angle = xj[2] - xi[2] - z[2]
    return np.array([c * d[0] + s * d[1] - z[0], c * d[1] - s * d[0] - z[1], np.arctan2(np.sin(angle), np.cos(angle))])


def err_l(xi, l, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    d = l - xi[:2]
    return np.array([c * d[0] + s * d[1] - z[0], c * d[1] - s * d[0] - z[1]])


def jac(f, x, h=1e-6):
    e = f(x)
    return np.column_stack([(f(x + h * v) - e) / h for v in np.eye(len(x))])


def systeme(poses, amers, aretes, observations):
    n, m = len(poses), len(amers)
    N = 3 * n + 2 * m
    H, b = np.zeros((N, N)), np.zeros(N)
    for liste, err, debut, taille, noeuds in (
        (aretes, err_p, 0, 3, poses),
        (observations, err_l, 3 * n, 2, amers),
    ):
        for i, j, z, omega in liste:
            xi, xj = poses[i], noeuds[j]
            J = np.zeros((len(z), N))
            J[:, 3 * i : 3 * i + 3] = jac(lambda x: err(x, xj, z), xi)
            J[:, debut + taille * j : debut + taille * (j + 1)] = jac(lambda x: err(xi, x, z), xj)
            H += J.T @ omega @ J
            b += J.T @ omega @ err(xi, xj, z)
    return H, b


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    p, l = poses.copy(), amers.copy()
    for k in range(n_iter):
        H, b = systeme(p, l, aretes, observations)
        H[:3, :3] += 1e9 * np.eye(3)
        dx = np.linalg.solve(H, -b)
        p += dx[: 3 * len(p)].reshape(-1, 3)
        l += dx[3 * len(p) :].reshape(-1, 2)
        p[:, 2] = np.arctan2(np.sin(p[:, 2]), np.cos(p[:, 2]))
    return p, l
