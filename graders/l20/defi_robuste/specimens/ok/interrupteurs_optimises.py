from scipy.linalg import null_space
from scipy.optimize import least_squares


def residus(x, aretes):
    r = []
    for i, j, z, om in aretes:
        c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
        R = np.array([[c, s], [-s, c]])
        t = x[j, 2] - x[i, 2] - z[2]
        r.append(np.sqrt(np.diag(om)) * np.append(R @ (x[j, :2] - x[i, :2]) - z[:2], np.arctan2(np.sin(t), np.cos(t))))
    return np.array(r)


def jacobienne(x, aretes):
    J = np.zeros((len(aretes), 3, x.size))
    for k, (i, j, z, om) in enumerate(aretes):
        c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
        dx, dy = x[j, :2] - x[i, :2]
        A = [[-c, -s, c * dy - s * dx], [s, -c, -c * dx - s * dy], [0, 0, -1]]
        J[k, :, 3 * i : 3 * i + 3] = A
        J[k, :, 3 * j : 3 * j + 3] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
        J[k] = np.sqrt(np.diag(om))[:, None] * J[k]
    return J


def dimension_noyau(poses, aretes):
    return null_space(jacobienne(poses, aretes).reshape(-1, poses.size), rcond=1e-8).shape[1]


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    """Contraintes commutables : les interrupteurs sont des inconnues, avec un a priori vers 1."""
    n, douteuses = len(poses), [k for k, a in enumerate(aretes) if abs(a[0] - a[1]) != 1]

    def lire(u):
        s = np.ones(len(aretes))
        s[douteuses] = u[3 * n - 3 :]
        return np.vstack([poses[:1], u[: 3 * n - 3].reshape(-1, 3)]), s

    def f(u):
        x, s = lire(u)
        return np.concatenate([(s[:, None] * residus(x, aretes)).ravel(), delta * (1 - s[douteuses])])

    def df(u):
        x, s = lire(u)
        r, J = residus(x, aretes), jacobienne(x, aretes)
        haut = np.zeros((3 * len(aretes), len(u)))
        haut[:, : 3 * n - 3] = (s[:, None, None] * J).reshape(-1, 3 * n)[:, 3:]
        bas = np.zeros((len(douteuses), len(u)))
        for q, k in enumerate(douteuses):
            haut[3 * k : 3 * k + 3, 3 * n - 3 + q] = r[k]
            bas[q, 3 * n - 3 + q] = -delta
        return np.vstack([haut, bas])

    u = np.concatenate([poses[1:].ravel(), np.ones(len(douteuses))])
    # Les interrupteurs partent de leur meilleure valeur au départ.
    carres = np.sum(residus(poses, aretes) ** 2, axis=1)
    u[3 * n - 3 :] = delta**2 / (delta**2 + carres[douteuses])
    x, s = lire(least_squares(f, u, jac=df, max_nfev=5 * n_iter).x)
    x[:, 2] = np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))
    return x, np.clip(s, 0, 1) ** 2
