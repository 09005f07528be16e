def ajoute(H, b, ou, J, w, e):
    for r, p in enumerate(ou):
        b[p] += J[:, r] @ w @ e
        for c, q in enumerate(ou):
            H[p, q] += J[:, r] @ w @ J[:, c]


def systeme(poses, amers, aretes, observations):
    n = len(poses)
    H = np.zeros((3 * n + 2 * len(amers),) * 2)
    b = np.zeros(len(H))
    for i, j, z, w in aretes:
        c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
        dx, dy = poses[j, 0] - poses[i, 0], poses[j, 1] - poses[i, 1]
        t = poses[j, 2] - poses[i, 2] - z[2]
        e = np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], np.pi - (np.pi - t) % (2 * np.pi)])
        J = np.array([[-c, -s, -s * dx + c * dy, c, s, 0], [s, -c, -c * dx - s * dy, -s, c, 0], [0, 0, -1, 0, 0, 1]])
        ajoute(H, b, [3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2], J, w, e)
    for i, j, z, w in observations:
        c, s = np.cos(poses[i, 2]), np.sin(poses[i, 2])
        dx, dy = amers[j, 0] - poses[i, 0], amers[j, 1] - poses[i, 1]
        J = np.array([[-c, -s, -s * dx + c * dy, c, s], [s, -c, -c * dx - s * dy, -s, c]])
        e = np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1]])
        ajoute(H, b, [3 * i, 3 * i + 1, 3 * i + 2, 3 * n + 2 * j, 3 * n + 2 * j + 1], J, w, e)
    return H, b


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    """Le pas le plus petit, sans jauge ; à la fin, toute la carte est ramenée pour que la première pose soit en place."""
    x, l = poses + 0.0, amers + 0.0
    n = len(x)
    for _ in range(n_iter):
        H, b = systeme(x, l, aretes, observations)
        d = -np.linalg.pinv(H, rcond=1e-10) @ b
        x += d[: 3 * n].reshape(n, 3)
        l += d[3 * n :].reshape(-1, 2)
    t = poses[0, 2] - x[0, 2]
    R = np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])
    l = (l - x[0, :2]) @ R.T + poses[0, :2]
    x[:, :2] = (x[:, :2] - x[0, :2]) @ R.T + poses[0, :2]
    x[:, 2] = np.pi - (np.pi - x[:, 2] - t) % (2 * np.pi)
    return x, l
