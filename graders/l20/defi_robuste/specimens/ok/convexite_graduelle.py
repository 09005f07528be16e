def erreurs(x, aretes):
    for i, j, z, om in aretes:
        R = np.array([[np.cos(x[i, 2]), np.sin(x[i, 2])], [-np.sin(x[i, 2]), np.cos(x[i, 2])]])
        vu = R @ (x[j, :2] - x[i, :2])
        t = x[j, 2] - x[i, 2] - z[2]
        e = np.append(vu - z[:2], t - 2 * np.pi * np.round(t / (2 * np.pi)))
        A = np.block([[-R, np.array([[vu[1]], [-vu[0]]])], [np.zeros((1, 2)), -np.ones((1, 1))]])
        B = np.block([[R, np.zeros((2, 1))], [np.zeros((1, 2)), np.ones((1, 1))]])
        yield e, A, B


def H_et_b(x, aretes, w):
    N = x.size
    H, b = np.zeros((N, N)), np.zeros(N)
    for (i, j, z, om), (e, A, B), p in zip(aretes, erreurs(x, aretes), w):
        D = np.zeros((3, N))
        D[:, 3 * i : 3 * i + 3], D[:, 3 * j : 3 * j + 3] = A, B
        H += p * D.T @ om @ D
        b += p * D.T @ om @ e
    return H, b


def dimension_noyau(poses, aretes):
    H, _ = H_et_b(poses, aretes, np.ones(len(aretes)))
    return sum(abs(v) < 1e-9 * np.trace(H) for v in np.linalg.eigvals(H))


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    """Moindres carrés tronqués, durcis peu à peu ; la borne est 2δ² sur les fermetures."""
    x, borne = poses.copy(), 2 * delta**2
    douteuse = np.array([abs(a[0] - a[1]) != 1 for a in aretes])
    w, mu = np.ones(len(aretes)), None
    for _ in range(max(n_iter, 30)):
        for _ in range(2):
            H, b = H_et_b(x, aretes, w)
            x.flat[3:] -= np.linalg.solve(H[3:, 3:], b[3:])
            x[:, 2] -= 2 * np.pi * np.round(x[:, 2] / (2 * np.pi))
        u = np.array([e @ a[3] @ e for a, (e, _, _) in zip(aretes, erreurs(x, aretes))])
        if mu is None:
            mu = borne / max(1e-9, 2 * u[douteuse].max() - borne)
        bas, haut = mu / (mu + 1) * borne, (mu + 1) / mu * borne
        milieu = np.sqrt(borne * mu * (mu + 1) / np.maximum(u, 1e-12)) - mu
        w = np.where(douteuse, np.where(u <= bas, 1.0, np.where(u >= haut, 0.0, milieu)), 1.0)
        mu *= 1.4
    return x, w
