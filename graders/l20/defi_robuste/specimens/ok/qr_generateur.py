def lignes(x, aretes):
    """Une arête après l'autre : son bloc blanchi de J, et son erreur blanchie."""
    for i, j, z, om in aretes:
        c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
        dx, dy = x[j, :2] - x[i, :2]
        t = x[j, 2] - x[i, 2] - z[2]
        L = np.linalg.cholesky(om).T
        J = np.zeros((3, x.size))
        J[:, 3 * i : 3 * i + 3] = [[-c, -s, c * dy - s * dx], [s, -c, -c * dx - s * dy], [0, 0, -1]]
        J[:, 3 * j : 3 * j + 3] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        yield L @ J, L @ [c * dx + s * dy - z[0], c * dy - s * dx - z[1], t - 2 * np.pi * np.floor((t + np.pi) / (2 * np.pi))]


def dimension_noyau(poses, aretes):
    J = np.vstack([bloc for bloc, _ in lignes(poses, aretes)])
    manque = J.shape[1] - np.linalg.matrix_rank(J, tol=1e-7 * np.abs(J).max())
    return np.int64(manque)


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    x = poses + 0.0
    for _ in range(n_iter):
        blocs, seconds = [], []
        for J, r in lignes(x, aretes):
            # Huber, pondéré par la racine : (√w J, √w r) a pour carré w JᵀJ.
            racine = np.sqrt(min(1.0, delta / max(np.linalg.norm(r), 1e-12)))
            blocs.append(racine * J[:, 3:])
            seconds.append(racine * r)
        Q, R = np.linalg.qr(np.vstack(blocs))
        x[1:] -= np.linalg.solve(R, Q.T @ np.concatenate(seconds)).reshape(-1, 3)
    x[:, 2] -= 2 * np.pi * np.round(x[:, 2] / (2 * np.pi))
    return x, [[min(1.0, delta / max(np.linalg.norm(r), 1e-12))] for _, r in lignes(x, aretes)]
