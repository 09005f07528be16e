"""Levenberg's damping: a step that does not help is not taken; several tries count for one iteration."""


def relatif(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    R = np.array([[c, s], [-s, c]])
    return np.concatenate([R @ (b[:2] - a[:2]), [b[2] - a[2]]])


def erreur(xi, xj, z):
    e = relatif(xi, xj) - z
    e[2] = np.arctan2(np.sin(e[2]), np.cos(e[2]))
    return e


def cout(x, aretes):
    return sum(erreur(x[i], x[j], z) @ o @ erreur(x[i], x[j], z) for i, j, z, o in aretes)


def derivees(a, b):
    r = relatif(a, b)
    c, s = np.cos(a[2]), np.sin(a[2])
    B = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    A = -B
    A[:2, 2] = r[1], -r[0]
    return A, B


def gauss_newton(poses, aretes, n_iter=10):
    x, amorti = np.array(poses), 1e-6
    for _ in range(n_iter):
        H, g = np.zeros((x.size, x.size)), np.zeros(x.size)
        for i, j, z, o in aretes:
            A, B = derivees(x[i], x[j])
            ici, la = np.r_[3 * i:3 * i + 3], np.r_[3 * j:3 * j + 3]
            for p, U in ((ici, A), (la, B)):
                g[p] += U.T @ o @ erreur(x[i], x[j], z)
                for q, V in ((ici, A), (la, B)):
                    H[np.ix_(p, q)] += U.T @ o @ V
        avant = cout(x, aretes)
        for _essai in range(12):
            d = np.linalg.solve(H[3:, 3:] + amorti * np.eye(x.size - 3), -g[3:])
            nouveau = x + np.concatenate([np.zeros(3), d]).reshape(-1, 3)
            nouveau[:, 2] = np.arctan2(np.sin(nouveau[:, 2]), np.cos(nouveau[:, 2]))
            if cout(nouveau, aretes) <= avant:
                x, amorti = nouveau, amorti / 10
                break
            amorti *= 10
    return x
