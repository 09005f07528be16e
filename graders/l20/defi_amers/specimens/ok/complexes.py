def morceaux(poses, amers, aretes, observations):
    p = poses[:, 0] + 1j * poses[:, 1]
    cap = np.exp(1j * poses[:, 2])
    l = amers[:, 0] + 1j * amers[:, 1]
    n = len(poses)
    for i, j, z, om in aretes:
        vu = (p[j] - p[i]) / cap[i]
        ecart = vu - complex(z[0], z[1])
        tour = np.angle(cap[j] / cap[i] * np.exp(-1j * z[2]))
        yield np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3], colonnes(-1 / cap[i], -1j / cap[i], -1j * vu, 1 / cap[i], 1j / cap[i], 0, bas=(0, 0, -1, 0, 0, 1)), om, np.array([ecart.real, ecart.imag, tour])
    for i, j, z, om in observations:
        vu = (l[j] - p[i]) / cap[i]
        ecart = vu - complex(z[0], z[1])
        yield np.r_[3 * i : 3 * i + 3, 3 * n + 2 * j : 3 * n + 2 * j + 2], colonnes(-1 / cap[i], -1j / cap[i], -1j * vu, 1 / cap[i], 1j / cap[i]), om, np.array([ecart.real, ecart.imag])


def colonnes(*valeurs, bas=None):
    valeurs = np.array(valeurs, dtype=complex)
    lignes = [valeurs.real, valeurs.imag]
    return np.array(lignes if bas is None else [*lignes, bas])


def systeme(poses, amers, aretes, observations):
    N = poses.size + amers.size
    H, b = np.zeros((N, N)), np.zeros(N)
    for ou, J, om, e in morceaux(poses, amers, aretes, observations):
        H[np.ix_(ou, ou)] += J.T @ om @ J
        b[ou] -= J.T @ om @ e
    return [H, b]


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    for _ in range(n_iter):
        H, moins_b = systeme(poses, amers, aretes, observations)
        pas = np.concatenate([np.zeros(3), np.linalg.solve(H[3:, 3:], moins_b[3:])])
        poses = poses + pas[: poses.size].reshape(-1, 3)
        amers = amers + pas[poses.size :].reshape(-1, 2)
        poses[:, 2] = np.angle(np.exp(1j * poses[:, 2]))
    return [poses, amers]
