def ramener(t):
    while t > np.pi:
        t -= 2 * np.pi
    while t <= -np.pi:
        t += 2 * np.pi
    return t


def voir(p, q):
    c, s = np.cos(p[2]), np.sin(p[2])
    dx, dy = q[0] - p[0], q[1] - p[1]
    return np.array([c * dx + s * dy, c * dy - s * dx])


def lineaire(poses, amers, aretes, observations):
    n = len(poses)
    for i, j, z, omega in aretes:
        u = voir(poses[i], poses[j])
        e = np.array([u[0] - z[0], u[1] - z[1], ramener(poses[j][2] - poses[i][2] - z[2])])
        c, s = np.cos(poses[i][2]), np.sin(poses[i][2])
        J = {i: np.array([[-c, -s, u[1]], [s, -c, -u[0]], [0, 0, -1]]), j: np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])}
        yield {3 * k: M for k, M in J.items()}, e, omega
    for i, j, z, omega in observations:
        u = voir(poses[i], amers[j])
        c, s = np.cos(poses[i][2]), np.sin(poses[i][2])
        yield {3 * i: np.array([[-c, -s, u[1]], [s, -c, -u[0]]]), 3 * n + 2 * j: np.array([[c, s], [-s, c]])}, u - z, omega


def systeme(poses, amers, aretes, observations):
    taille = 3 * len(poses) + 2 * len(amers)
    H, b = np.zeros((taille, taille)), np.zeros(taille)
    for blocs, e, omega in lineaire(poses, amers, aretes, observations):
        for r, A in blocs.items():
            b[r : r + A.shape[1]] += A.T @ omega @ e
            for k, B in blocs.items():
                H[r : r + A.shape[1], k : k + B.shape[1]] += A.T @ omega @ B
    return np.asmatrix(H), b


def chi2(poses, amers, aretes, observations):
    return sum(e @ omega @ e for _, e, omega in lineaire(poses, amers, aretes, observations))


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    amortissement = 1e-4
    avant = chi2(poses, amers, aretes, observations)
    for _ in range(n_iter):
        H, b = systeme(poses, amers, aretes, observations)
        H = np.asarray(H)[3:, 3:]
        pas = np.append(np.zeros(3), np.linalg.solve(H + amortissement * np.diag(np.diag(H)), -b[3:]))
        p = poses + pas[: 3 * len(poses)].reshape(-1, 3)
        a = amers + pas[3 * len(poses) :].reshape(-1, 2)
        p[:, 2] = [ramener(t) for t in p[:, 2]]
        apres = chi2(p, a, aretes, observations)
        if apres <= avant:
            poses, amers, avant, amortissement = p, a, apres, amortissement / 10
        else:
            amortissement *= 10
    return poses, amers
