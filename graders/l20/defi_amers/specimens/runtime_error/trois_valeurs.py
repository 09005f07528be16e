def systeme(poses, amers, aretes, observations):
    n, m = len(poses), len(amers)
    for i, j, z in aretes:
        pass
    return np.eye(3 * n + 2 * m), np.zeros(3 * n + 2 * m)


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    H, b = systeme(poses, amers, aretes, observations)
    return poses, amers
