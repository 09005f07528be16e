def ramener(angle):
    return np.pi - (np.pi - angle) % (2 * np.pi)


def arete(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    e = np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], ramener(xj[2] - xi[2] - z[2])])
    A = np.array([[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0, 0, -1.0]])
    B = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    return e, A, B


def systeme(x, aretes, poids):
    n = len(x)
    H, b = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
    for (i, j, z, omega), w in zip(aretes, poids, strict=True):
        e, A, B = arete(x[i], x[j], z)
        I, J = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
        H[I, I] += w * A.T @ omega @ A
        H[I, J] += w * A.T @ omega @ B
        H[J, I] += w * B.T @ omega @ A
        H[J, J] += w * B.T @ omega @ B
        b[I] += w * A.T @ omega @ e
        b[J] += w * B.T @ omega @ e
    return H, b


def ponderer(x, aretes, delta):
    poids = []
    for i, j, z, omega in aretes:
        e = arete(x[i], x[j], z)[0]
        norme = np.sqrt(e @ omega @ e)
        poids.append(1.0 if norme <= delta else delta / norme)
    return np.array(poids)


def dimension_noyau(poses, aretes):
    H, b = systeme(poses, aretes, np.ones(len(aretes)))
    valeurs = np.linalg.eigvalsh(H)
    return int(np.sum(valeurs < 1e-6 * valeurs[-1]))


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    x = np.array(poses, dtype=float)
    n = len(x)
    for _ in range(n_iter):
        poids = ponderer(x, aretes, delta)
        H, b = systeme(x, aretes, poids)
        pas = np.zeros(3 * n)
        pas[3:] = np.linalg.solve(H[3:, 3:], -b[3:])
        x = x + pas.reshape(n, 3)
        x[:, 2] = ramener(x[:, 2])
    poids = ponderer(x, aretes, delta)
    return x, poids
