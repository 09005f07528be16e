def relatif(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    ex, ey = b[0] - a[0], b[1] - a[1]
    angle = b[2] - a[2]
    return np.array([c * ex + s * ey, c * ey - s * ex, np.pi - (np.pi - angle) % (2 * np.pi)])


def ate(estimees, verite):
    P, Q = estimees[:, :2], verite[:, :2]
    p, q = P.mean(axis=0), Q.mean(axis=0)
    A, B = P - p, Q - q
    U, S, Vt = np.linalg.svd(A.T @ B)
    D = np.diag([1.0, np.sign(np.linalg.det(Vt.T @ U.T))])
    R = Vt.T @ D @ U.T
    t = q - R @ p
    carres = np.sum((P @ R.T + t - Q) ** 2, axis=1)
    return np.sqrt(np.mean(carres))


def rpe(estimees, verite, delta):
    n = len(verite)
    erreurs = []
    for i in range(n - delta):
        d = relatif(estimees[i], estimees[i + delta])
        v = relatif(verite[i], verite[i + delta])
        e = relatif(v, d)
        erreurs.append(e[0] ** 2 + e[1] ** 2)
    return np.sqrt(np.mean(erreurs))
