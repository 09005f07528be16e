def empiler(X, L, E, O):
    """J et r blanchis, sans jamais former H : Gauss-Newton par une décomposition QR."""
    n = len(X)
    J, r = [], []
    for i, j, z, W in list(E) + list(O):
        S = np.linalg.cholesky(W).T
        but = X[j] if len(z) == 3 else L[j]
        ou = 3 * j if len(z) == 3 else 3 * n + 2 * j
        c, s = np.cos(X[i][2]), np.sin(X[i][2])
        R = np.array([[c, s], [-s, c]])
        d = but[:2] - X[i][:2]
        bloc = np.zeros((len(z), 3 * n + 2 * len(L)))
        bloc[:2, 3 * i : 3 * i + 2] = -R
        bloc[:2, 3 * i + 2] = np.array([[-s, c], [-c, -s]]) @ d
        bloc[:2, ou : ou + 2] = R
        e = list(R @ d - z[:2])
        if len(z) == 3:
            bloc[2, 3 * i + 2], bloc[2, ou + 2] = -1, 1
            t = but[2] - X[i][2] - z[2]
            e += [np.arctan2(np.sin(t), np.cos(t))]
        J.append(S @ bloc)
        r.append(S @ e)
    return np.vstack(J), np.concatenate(r)


def systeme(X, L, E, O):
    J, r = empiler(X, L, E, O)
    return J.T @ J, J.T @ r


def slam_amers(X, L, E, O, n_iter=10):
    X, L = np.array(X), np.array(L)
    for _ in range(n_iter):
        J, r = empiler(X, L, E, O)
        Q, T = np.linalg.qr(J[:, 3:])
        d = np.linalg.solve(T, -Q.T @ r)
        X[1:] += d[: X.size - 3].reshape(-1, 3)
        L += d[X.size - 3 :].reshape(-1, 2)
        X[:, 2] = np.arctan2(np.sin(X[:, 2]), np.cos(X[:, 2]))
    return X, L
