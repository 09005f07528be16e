def err(a, b, z):
    c, s = np.cos(a[2]), np.sin(a[2])
    t = b[2] - a[2] - z[2]
    return np.array(
        [
            c * (b[0] - a[0]) + s * (b[1] - a[1]) - z[0],
            -s * (b[0] - a[0]) + c * (b[1] - a[1]) - z[1],
            np.pi - (np.pi - t) % (2 * np.pi),
        ]
    )


def tout(u, aretes):
    x = u.reshape(-1, 3)
    return np.concatenate([np.sqrt(np.diag(w)) * err(x[i], x[j], z) for i, j, z, w in aretes])


def jacobienne(u, aretes, h=1e-6):
    """Par différences finies, mais seulement là où chaque arête dépend des poses."""
    x = u.reshape(-1, 3)
    J = np.zeros((3 * len(aretes), u.size))
    for k, (i, j, z, w) in enumerate(aretes):
        racine = np.sqrt(np.diag(w))
        e = err(x[i], x[j], z)
        for c in range(3):
            d = np.zeros(3)
            d[c] = h
            J[3 * k : 3 * k + 3, 3 * i + c] = racine * (err(x[i] + d, x[j], z) - e) / h
            J[3 * k : 3 * k + 3, 3 * j + c] = racine * (err(x[i], x[j] + d, z) - e) / h
    return J


def dimension_noyau(poses, aretes):
    s = np.linalg.svd(jacobienne(poses.ravel(), aretes), compute_uv=False)
    return poses.size - int(np.sum(s > 1e-4 * s[0]))


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    u = poses.ravel().copy()
    for _ in range(n_iter):
        r = tout(u, aretes)
        w = 1 / (1 + np.sum(r.reshape(-1, 3) ** 2, axis=1) / delta**2)
        q = np.repeat(np.sqrt(w), 3)
        J = jacobienne(u, aretes)[:, 3:] * q[:, None]
        u[3:] -= np.linalg.lstsq(J, q * r, rcond=None)[0]
    u = u.reshape(-1, 3)
    u[:, 2] = np.arctan2(np.sin(u[:, 2]), np.cos(u[:, 2]))
    r = tout(u.ravel(), aretes).reshape(-1, 3)
    return u, 1 / (1 + np.sum(r**2, axis=1) / delta**2)
