def systeme(poses, amers, aretes, observations):
    n, m = len(poses), len(amers)
    H, b = np.zeros((3 * n + 2 * m, 3 * n + 2 * m)), np.zeros(3 * n + 2 * m)


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    poses = poses + 0.0
