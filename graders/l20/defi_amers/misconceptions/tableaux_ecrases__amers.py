def slam_amers(poses, amers, aretes, observations, n_iter=10):
    x, a = poses.copy(), amers
    n = len(x)
    for _ in range(n_iter):
        H, b = systeme(x, a, aretes, observations)
        pas = np.zeros(len(b))
        pas[3:] = np.linalg.solve(H[3:, 3:], -b[3:])
        x += pas[: 3 * n].reshape(n, 3)
        a += pas[3 * n :].reshape(-1, 2)
        x[:, 2] = ramener(x[:, 2])
    return x, a
