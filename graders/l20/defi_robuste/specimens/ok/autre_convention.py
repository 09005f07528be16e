def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    t = a[2] + b[2]
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], np.arctan2(np.sin(t), np.cos(t))])


def relatif(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    return composer(np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]]), b)


def derivees(a, b, z):
    """L'erreur vue depuis la mesure, et ses dérivées pour des pas vus de chaque robot : a ⊕ δ."""
    f = lambda u, v: relatif(z, relatif(composer(a, u), composer(b, v)))
    h, o = 1e-5, np.zeros(3)
    A = np.stack([(f(h * d, o) - f(-h * d, o)) / (2 * h) for d in np.eye(3)], axis=1)
    B = np.stack([(f(o, h * d) - f(o, -h * d)) / (2 * h) for d in np.eye(3)], axis=1)
    return f(o, o), A, B


def lineaire(x, aretes, noter):
    N = 3 * len(x)
    H, b, notes = np.zeros((N, N)), np.zeros(N), []
    for i, j, z, om in aretes:
        e, A, B = derivees(x[i], x[j], z)
        w = noter(np.sqrt(e @ om @ e))
        notes.append(w)
        I, J = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
        for P, U in ((I, A), (J, B)):
            b[P] += w * U.T @ om @ e
            for Q, V in ((I, A), (J, B)):
                H[P, Q] += w * U.T @ om @ V
    return H, b, notes


def dimension_noyau(poses, aretes):
    H, _, _ = lineaire(poses, aretes, lambda r: 1.0)
    valeurs = np.linalg.eigvalsh(H)
    return int((valeurs < 1e-5 * valeurs.max()).sum())


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    x = list(poses)
    huber = lambda r: 1.0 if r <= delta else delta / r
    for _ in range(min(n_iter, 15)):
        H, b, _ = lineaire(x, aretes, huber)
        pas = np.linalg.solve(H[3:, 3:], -b[3:]).reshape(-1, 3)
        x = [x[0], *(composer(p, d) for p, d in zip(x[1:], pas))]
    return np.array(x), np.array(lineaire(x, aretes, huber)[2])
