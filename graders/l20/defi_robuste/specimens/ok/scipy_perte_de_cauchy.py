from scipy.optimize import least_squares
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components


def dimension_noyau(poses, aretes):
    i, j = [a[0] for a in aretes], [a[1] for a in aretes]
    n = len(poses)
    morceaux, _ = connected_components(coo_matrix((np.ones(len(i)), (i, j)), shape=(n, n)), directed=False)
    return 3 * morceaux


def blanchies(x, aretes):
    i, j = np.array([a[0] for a in aretes]), np.array([a[1] for a in aretes])
    z = np.array([a[2] for a in aretes])
    racines = np.sqrt(np.array([np.diag(a[3]) for a in aretes]))
    c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
    dx, dy, dt = (x[j] - x[i]).T
    t = dt - z[:, 2]
    return racines * np.stack([c * dx + s * dy - z[:, 0], c * dy - s * dx - z[:, 1], np.arctan2(np.sin(t), np.cos(t))], 1)


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    f = lambda u: blanchies(np.vstack([poses[:1], u.reshape(-1, 3)]), aretes).ravel()
    u = least_squares(f, poses[1:].ravel(), loss="cauchy", f_scale=delta, max_nfev=2 * n_iter).x
    x = np.vstack([poses[:1], u.reshape(-1, 3)])
    x[:, 2] = np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))
    return x, 1 / (1 + np.sum(blanchies(x, aretes) ** 2, axis=1) / delta**2)
