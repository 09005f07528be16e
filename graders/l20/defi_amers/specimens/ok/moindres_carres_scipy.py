from scipy.optimize import least_squares


def erreurs(u, n, aretes, observations):
    x, l = u[: 3 * n].reshape(n, 3), u[3 * n :].reshape(-1, 2)
    e = []
    for i, j, z, omega in aretes:
        c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
        dx, dy, a = x[j] - x[i]
        a = a - z[2]
        r = np.array([c * dx + s * dy - z[0], c * dy - s * dx - z[1], np.arctan2(np.sin(a), np.cos(a))])
        e.append(np.linalg.cholesky(omega).T @ r)
    for i, j, z, omega in observations:
        c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
        dx, dy = l[j] - x[i, :2]
        e.append(np.linalg.cholesky(omega).T @ [c * dx + s * dy - z[0], c * dy - s * dx - z[1]])
    return np.concatenate(e)


def systeme(poses, amers, aretes, observations):
    u = np.concatenate([poses.ravel(), amers.ravel()])
    f = lambda v: erreurs(v, len(poses), aretes, observations)
    h = 1e-5
    J = np.column_stack([(f(u + h * d) - f(u - h * d)) / (2 * h) for d in np.eye(len(u))])
    return J.T @ J, (J.T @ f(u))[:, None]


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    n = len(poses)
    u = np.concatenate([poses.ravel(), amers.ravel()])
    f = lambda v: erreurs(np.concatenate([u[:3], v]), n, aretes, observations)
    v = least_squares(f, u[3:], xtol=1e-12, ftol=1e-12, gtol=1e-12).x
    u = np.concatenate([u[:3], v])
    x = u[: 3 * n].reshape(n, 3)
    x[:, 2] = (x[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return x, u[3 * n :].reshape(-1, 2)
