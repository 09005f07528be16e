"""No gauge in the equations: the smallest step by the pseudo-inverse, then the whole graph put back on its first pose."""


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], (a[2] + b[2] + np.pi) % (2 * np.pi) - np.pi])


def relatif(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    d = b - a
    return np.array([c * d[0] + s * d[1], -s * d[0] + c * d[1], (d[2] + np.pi) % (2 * np.pi) - np.pi])


def erreur(xi, xj, z):
    return relatif(z, relatif(xi, xj))


def gauss_newton(poses, aretes, n_iter=10):
    x = poses.copy()
    for _ in range(n_iter):
        J = np.zeros((3 * len(aretes), x.size))
        r = np.zeros(3 * len(aretes))
        for k, (i, j, z, omega) in enumerate(aretes):
            l = slice(3 * k, 3 * k + 3)
            S = np.sqrt(omega)
            for p in (i, j):
                for q in range(3):
                    y = x.copy()
                    y[p, q] += 1e-7
                    J[l, 3 * p + q] = S @ (erreur(y[i], y[j], z) - erreur(x[i], x[j], z)) / 1e-7
            r[l] = S @ erreur(x[i], x[j], z)
        x = x - (np.linalg.pinv(J, rcond=1e-6) @ r).reshape(-1, 3)
    premiere = relatif(x[0], np.zeros(3))
    return np.array([composer(poses[0], composer(premiere, p)) for p in x])
