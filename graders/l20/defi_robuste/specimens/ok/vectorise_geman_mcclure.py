def preparer(aretes):
    i, j, z, w = zip(*aretes)
    return np.array(i), np.array(j), np.array(z), np.array(w)


def lineariser(x, i, j, z):
    c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
    d = x[j] - x[i]
    t = d[:, 2] - z[:, 2]
    e = np.stack([c * d[:, 0] + s * d[:, 1] - z[:, 0], c * d[:, 1] - s * d[:, 0] - z[:, 1], (t + np.pi) % (2 * np.pi) - np.pi], 1)
    J = np.zeros((len(i), 3, x.size))
    k = np.arange(len(i))
    for a, b, v in ((0, 0, c), (0, 1, s), (1, 0, -s), (1, 1, c), (2, 2, np.ones(len(i)))):
        J[k, a, 3 * j + b] += v
        J[k, a, 3 * i + b] -= v
    J[k, 0, 3 * i + 2] += -s * d[:, 0] + c * d[:, 1]
    J[k, 1, 3 * i + 2] += -c * d[:, 0] - s * d[:, 1]
    return e, J


def dimension_noyau(poses, aretes):
    i, j, z, w = preparer(aretes)
    e, J = lineariser(poses, i, j, z)
    return poses.size - np.linalg.matrix_rank(np.einsum("kai,kab,kbj->ij", J, w, J))


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    i, j, z, om = preparer(aretes)
    x = np.array(poses)
    w = np.ones(len(i))
    for _ in range(n_iter):
        e, J = lineariser(x, i, j, z)
        w = (delta**2 / (delta**2 + np.einsum("ka,kab,kb->k", e, om, e))) ** 2
        oJ = np.einsum("k,kab,kbi->kai", w, om, J)
        H, b = np.einsum("kai,kaj->ij", J, oJ, optimize=True), np.einsum("kai,ka->i", oJ, e)
        x[1:] -= np.linalg.solve(H[3:, 3:], b[3:]).reshape(-1, 3)
        x[:, 2] = np.angle(np.exp(1j * x[:, 2]))
    return x, w
