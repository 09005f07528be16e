def tout(poses, amers, aretes, observations):
    """La jacobienne blanchie de toutes les mesures, et leur erreur blanchie, d'un coup."""
    n, N = len(poses), poses.size + amers.size
    i, j = (np.array([a[k] for a in aretes]) for k in (0, 1))
    z, om = np.array([a[2] for a in aretes]), np.array([a[3] for a in aretes])
    k, l = (np.array([o[q] for o in observations]) for q in (0, 1))
    y, psi = np.array([o[2] for o in observations]), np.array([o[3] for o in observations])
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    Rt = np.stack([np.stack([c, s], -1), np.stack([-s, c], -1)], 1)
    dRt = np.stack([np.stack([-s, c], -1), np.stack([-c, -s], -1)], 1)
    d = poses[j, :2] - poses[i, :2]
    J = np.zeros((len(i), 3, N))
    r = np.arange(len(i))
    J[r[:, None, None], np.arange(2)[:, None], 3 * i[:, None, None] + np.arange(2)] = -Rt[i]
    J[r[:, None], np.arange(2), 3 * i[:, None] + 2] = np.einsum("mab,mb->ma", dRt[i], d)
    J[r, 2, 3 * i + 2] = -1
    J[r[:, None, None], np.arange(2)[:, None], 3 * j[:, None, None] + np.arange(2)] = Rt[i]
    J[r, 2, 3 * j + 2] = 1
    a = poses[j, 2] - poses[i, 2] - z[:, 2]
    e = np.column_stack([np.einsum("mab,mb->ma", Rt[i], d) - z[:, :2], (a + np.pi) % (2 * np.pi) - np.pi])
    q = amers[l] - poses[k, :2]
    K = np.zeros((len(k), 2, N))
    t = np.arange(len(k))
    K[t[:, None, None], np.arange(2)[:, None], 3 * k[:, None, None] + np.arange(2)] = -Rt[k]
    K[t[:, None], np.arange(2), 3 * k[:, None] + 2] = np.einsum("mab,mb->ma", dRt[k], q)
    K[t[:, None, None], np.arange(2)[:, None], 3 * n + 2 * l[:, None, None] + np.arange(2)] = Rt[k]
    f = np.einsum("mab,mb->ma", Rt[k], q) - y
    return (J, om, e), (K, psi, f)


def systeme(poses, amers, aretes, observations):
    H, b = 0, 0
    for J, om, e in tout(poses, amers, aretes, observations):
        H = H + np.einsum("mai,mab,mbj->ij", J, om, J, optimize=True)
        b = b + np.einsum("mai,mab,mb->i", J, om, e)
    return H, b


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    n = len(poses)
    u = np.hstack([poses.ravel(), amers.ravel()])
    while n_iter > 0:
        x = u[: 3 * n].reshape(n, 3)
        H, b = systeme(x, u[3 * n :].reshape(-1, 2), aretes, observations)
        u = u - np.hstack([np.zeros(3), np.linalg.lstsq(H[3:, 3:], b[3:], rcond=None)[0]])
        n_iter -= 1
    x = u[: 3 * n].reshape(n, 3)
    x[:, 2] = np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))
    return x, u[3 * n :].reshape(-1, 2)
