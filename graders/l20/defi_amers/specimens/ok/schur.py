from functools import reduce


def blocs(x, y, z, poids, cap_compte):
    """Les quatre blocs et les deux morceaux d'une mesure entre la pose x et le point ou la pose y."""
    c, s = np.cos(x[2]), np.sin(x[2])
    R = np.array([[c, -s], [s, c]])
    vu = R.T @ (y[:2] - x[:2])
    e, A, B = vu - z[:2], np.c_[-R.T, [vu[1], -vu[0]]], R.T
    if cap_compte:
        ecart = y[2] - x[2] - z[2]
        e = np.append(e, ecart - 2 * np.pi * np.round(ecart / (2 * np.pi)))
        A, B = np.vstack([A, [0, 0, -1]]), np.block([[B, np.zeros((2, 1))], [np.zeros((1, 2)), np.ones((1, 1))]])
    return A.T @ poids @ A, A.T @ poids @ B, B.T @ poids @ B, A.T @ poids @ e, B.T @ poids @ e


def systeme(poses, amers, aretes, observations):
    n, m = len(poses), len(amers)
    Hpp, Hpl, Hll = np.zeros((3 * n, 3 * n)), np.zeros((3 * n, 2 * m)), np.zeros((2 * m, 2 * m))
    bp, bl = np.zeros(3 * n), np.zeros(2 * m)
    for i, j, z, w in aretes:
        P, Q = np.arange(3 * i, 3 * i + 3), np.arange(3 * j, 3 * j + 3)
        AA, AB, BB, a, b = blocs(poses[i], poses[j], z, w, True)
        Hpp[np.ix_(P, P)] += AA
        Hpp[np.ix_(P, Q)] += AB
        Hpp[np.ix_(Q, P)] += AB.T
        Hpp[np.ix_(Q, Q)] += BB
        bp[P] += a
        bp[Q] += b
    for i, j, z, w in observations:
        P, L = np.arange(3 * i, 3 * i + 3), np.arange(2 * j, 2 * j + 2)
        AA, AB, BB, a, b = blocs(poses[i], amers[j], z, w, False)
        Hpp[np.ix_(P, P)] += AA
        Hpl[np.ix_(P, L)] += AB
        Hll[np.ix_(L, L)] += BB
        bp[P] += a
        bl[L] += b
    return np.block([[Hpp, Hpl], [Hpl.T, Hll]]), np.concatenate([bp, bl])


def tour(carte, aretes, observations):
    poses, amers = carte
    n = len(poses)
    H, b = systeme(poses, amers, aretes, observations)
    Hpp, Hpl, Hll = H[3 : 3 * n, 3 : 3 * n], H[3 : 3 * n, 3 * n :], H[3 * n :, 3 * n :]
    inverse = np.linalg.inv(Hll)
    dp = np.linalg.solve(Hpp - Hpl @ inverse @ Hpl.T, -b[3 : 3 * n] + Hpl @ inverse @ b[3 * n :])
    dl = inverse @ (-b[3 * n :] - Hpl.T @ dp)
    poses = poses + np.r_[0, 0, 0, dp].reshape(n, 3)
    poses[:, 2] -= 2 * np.pi * np.round(poses[:, 2] / (2 * np.pi))
    return poses, amers + dl.reshape(-1, 2)


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    return reduce(lambda carte, _: tour(carte, aretes, observations), range(n_iter), (poses, amers))
