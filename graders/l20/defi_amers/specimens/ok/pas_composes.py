from scipy.linalg import block_diag, cho_factor, cho_solve


def R(t):
    return np.array([[np.cos(t), -np.sin(t)], [np.sin(t), np.cos(t)]])


S = np.array([[0.0, -1.0], [1.0, 0.0]])


def mesure(a, b, z):
    """Erreur et dérivées, par rapport aux coordonnées du monde."""
    r = R(a[2]).T
    vu = r @ (b[:2] - a[:2])
    e, A, B = vu - z[:2], np.hstack([-r, (-S @ vu)[:, None]]), r
    if len(b) == 3:
        t = b[2] - a[2] - z[2]
        e = np.append(e, np.arctan2(np.sin(t), np.cos(t)))
        A, B = np.vstack([A, [[0, 0, -1]]]), block_diag(B, 1)
    return e, A, B


def parcourir(poses, amers, aretes, observations):
    for liste, noeuds, debut, taille in ((aretes, poses, 0, 3), (observations, amers, 3 * len(poses), 2)):
        for i, j, z, w in liste:
            yield slice(3 * i, 3 * i + 3), slice(debut + taille * j, debut + taille * j + taille), mesure(poses[i], noeuds[j], z), w


def systeme(poses, amers, aretes, observations):
    N = 3 * len(poses) + 2 * len(amers)
    H, b = np.zeros((N, N)), np.zeros(N)
    for I, J, (e, A, B), w in parcourir(poses, amers, aretes, observations):
        for u, U in ((I, A), (J, B)):
            b[u] += U.T @ (w @ e)
            for v, V in ((I, A), (J, B)):
                H[u, v] += U.T @ w @ V
    return H, b


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    """Des pas vus du robot : x ⊕ δ, où les colonnes de H sont tournées du cap de chaque pose."""
    poses, amers = poses.copy(), amers.copy()
    for _ in range(n_iter):
        H, b = systeme(poses, amers, aretes, observations)
        M = block_diag(*[block_diag(R(p[2]), 1) for p in poses], np.eye(amers.size))
        K, k = (M.T @ H @ M)[3:, 3:], (M.T @ b)[3:]
        d = np.concatenate([np.zeros(3), cho_solve(cho_factor(K), -k)])
        for p, u in zip(poses, d[: poses.size].reshape(-1, 3)):
            p[:2] += R(p[2]) @ u[:2]
            p[2] = np.arctan2(np.sin(p[2] + u[2]), np.cos(p[2] + u[2]))
        amers += d[poses.size :].reshape(-1, 2)
    return poses, amers
