"""QR of the stacked Jacobian instead of H; the wrap by rounding to whole turns; stops when nothing moves."""
from scipy.linalg import qr, solve_triangular


def angle(t):
    return t - 2 * np.pi * np.round(t / (2 * np.pi))


def erreur(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    u, v = xj[:2] - xi[:2]
    return np.array([c * u + s * v - z[0], c * v - s * u - z[1], angle(xj[2] - xi[2] - z[2])])


def gauss_newton(poses, aretes, n_iter=10):
    x = np.array(poses, copy=True)
    poids = [np.sqrt(np.diag(omega)) for *_, omega in aretes]
    for tour in range(max(n_iter, 0)):
        J = np.zeros((3 * len(aretes), 3 * len(x)))
        r = np.zeros(3 * len(aretes))
        for k, (i, j, z, _) in enumerate(aretes):
            c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
            u, v = x[j, :2] - x[i, :2]
            bloc = J[3 * k:3 * k + 3]
            bloc[:, 3 * i:3 * i + 3] += [[-c, -s, c * v - s * u], [s, -c, -c * u - s * v], [0, 0, -1]]
            bloc[:, 3 * j:3 * j + 3] += [[c, s, 0], [-s, c, 0], [0, 0, 1]]
            bloc *= poids[k][:, None]
            r[3 * k:3 * k + 3] = poids[k] * erreur(x[i], x[j], z)
        Q, T = qr(J[:, 3:], mode="economic")
        d = solve_triangular(T, -Q.T @ r)
        x[1:] += d.reshape(-1, 3)
        x[:, 2] = angle(x[:, 2])
        if abs(d).max() < 1e-13:
            break
    return x
