def ecart(a, b, z):
    R = np.array([[np.cos(a[2]), np.sin(a[2])], [-np.sin(a[2]), np.cos(a[2])]])
    t = b[2] - a[2] - z[2]
    while t > np.pi:
        t -= 2 * np.pi
    while t < -np.pi:
        t += 2 * np.pi
    return np.append(R @ (b[:2] - a[:2]) - z[:2], t), R


def cout_et_systeme(x, aretes, delta):
    phi, N = delta**2, x.size
    H, b, cout, poids = np.zeros((N, N)), np.zeros(N), 0.0, []
    for i, j, z, om in aretes:
        e, R = ecart(x[i], x[j], z)
        u = e @ om @ e
        w = 1.0 if phi is np.inf else min(1.0, 2 * phi / (phi + u)) ** 2
        cout += u if u <= phi else phi * (3 * u - phi) / (u + phi)
        vu = e[:2] + z[:2]
        A = np.array([[-R[0, 0], -R[0, 1], vu[1]], [-R[1, 0], -R[1, 1], -vu[0]], [0, 0, -1]])
        B = np.array([[R[0, 0], R[0, 1], 0], [R[1, 0], R[1, 1], 0], [0, 0, 1]])
        I, J = range(3 * i, 3 * i + 3), range(3 * j, 3 * j + 3)
        H[np.ix_(I, I)] += w * A.T @ om @ A
        H[np.ix_(I, J)] += w * A.T @ om @ B
        H[np.ix_(J, I)] += w * B.T @ om @ A
        H[np.ix_(J, J)] += w * B.T @ om @ B
        b[I] += w * A.T @ om @ e
        b[J] += w * B.T @ om @ e
        poids.append(w)
    return cout, H, b, poids


def dimension_noyau(poses, aretes):
    _, H, _, _ = cout_et_systeme(poses, aretes, 1e6)
    # Une petite diagonale rend H définie positive : son déterminant compte les valeurs nulles.
    a, b = 1e-9, 1e-8
    logs = [np.linalg.slogdet(H + q * np.eye(len(H)))[1] for q in (a, b)]
    return int(round((logs[1] - logs[0]) / np.log(b / a)))


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    x, lam = poses.copy(), 1e-3
    cout, H, b, poids = cout_et_systeme(x, aretes, delta)
    for _ in range(n_iter):
        M = H[3:, 3:]
        pas = np.linalg.solve(M + lam * np.diag(np.diag(M)), -b[3:])
        y = x + np.concatenate([np.zeros(3), pas]).reshape(-1, 3)
        y[:, 2] = np.arctan2(np.sin(y[:, 2]), np.cos(y[:, 2]))
        essai = cout_et_systeme(y, aretes, delta)
        if essai[0] < cout:
            x, (cout, H, b, poids), lam = y, essai, lam / 5
        else:
            lam *= 4
    return x, np.array(poids)
