def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    t = a[2] + b[2]
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], np.arctan2(np.sin(t), np.cos(t))])


def relatif(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    return composer(np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]]), b)


def e_pose(a, b, z):
    return relatif(z, relatif(a, b))  # pour diag(a, a, b), le même système


def e_amer(a, l, z):
    return relatif(a, np.array([l[0], l[1], 0.0]))[:2] - z


def derivee(f, x):
    h = 1e-6
    return np.stack([(f(x + h * d) - f(x - h * d)) / (2 * h) for d in np.eye(x.size)], axis=1)


def systeme(poses, amers, aretes, observations):
    n = len(poses)
    N = poses.size + amers.size
    J, W, e = [], [], []
    for i, j, z, w in aretes:
        D = np.zeros((3, N))
        D[:, 3 * i : 3 * i + 3] = derivee(lambda x: e_pose(x, poses[j], z), poses[i])
        D[:, 3 * j : 3 * j + 3] = derivee(lambda x: e_pose(poses[i], x, z), poses[j])
        J, W, e = J + [D], W + [w], e + [e_pose(poses[i], poses[j], z)]
    for i, j, z, w in observations:
        D = np.zeros((2, N))
        D[:, 3 * i : 3 * i + 3] = derivee(lambda x: e_amer(x, amers[j], z), poses[i])
        D[:, 3 * n + 2 * j : 3 * n + 2 * j + 2] = derivee(lambda x: e_amer(poses[i], x, z), amers[j])
        J, W, e = J + [D], W + [w], e + [e_amer(poses[i], amers[j], z)]
    return sum(D.T @ w @ D for D, w in zip(J, W)), sum(D.T @ w @ r for D, w, r in zip(J, W, e))


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    for _ in range(min(n_iter, 12)):
        H, b = systeme(poses, amers, aretes, observations)
        pas = np.concatenate([np.zeros(3), np.linalg.solve(H[3:, 3:], -b[3:])])
        poses = poses + pas[: poses.size].reshape(-1, 3)
        amers = amers + pas[poses.size :].reshape(-1, 2)
        poses[:, 2] = np.arctan2(np.sin(poses[:, 2]), np.cos(poses[:, 2]))
        if np.linalg.norm(pas) < 1e-8:
            break
    return poses, amers
