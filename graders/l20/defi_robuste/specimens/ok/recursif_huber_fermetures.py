def colorier(k, voisins, vus):
    if k in vus:
        return vus
    vus = vus | {k}
    for v in voisins[k]:
        vus = colorier(v, voisins, vus)
    return vus


def dimension_noyau(poses, aretes, fait=frozenset()):
    voisins = [[b if a == k else a for a, b, *_ in aretes if k in (a, b)] for k in range(len(poses))]
    reste = [k for k in range(len(poses)) if k not in fait]
    if not reste:
        return 0
    return 3 + dimension_noyau(poses, aretes, fait | colorier(reste[0], voisins, frozenset()))


def une_arete(x, i, j, z):
    c, s = np.cos(x[i][2]), np.sin(x[i][2])
    dx, dy = x[j][0] - x[i][0], x[j][1] - x[i][1]
    t = x[j][2] - x[i][2] - z[2]
    e = [c * dx + s * dy - z[0], c * dy - s * dx - z[1], np.arctan2(np.sin(t), np.cos(t))]
    return np.array(e), np.array([[-c, -s, c * dy - s * dx, c, s, 0], [s, -c, -c * dx - s * dy, -s, c, 0], [0, 0, -1, 0, 0, 1]])


def poids_de(x, arete, delta):
    i, j, z, om = arete
    if abs(i - j) == 1:
        return 1.0
    e, _ = une_arete(x, i, j, z)
    norme = (e @ om @ e) ** 0.5
    return delta / norme if norme > delta else 1.0


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    if n_iter == 0:
        return poses, tuple(poids_de(poses, a, delta) for a in aretes)
    H, b = np.zeros((poses.size, poses.size)), np.zeros(poses.size)
    for a in aretes:
        i, j, z, om = a
        e, J = une_arete(poses, i, j, z)
        om = om * poids_de(poses, a, delta)
        ou = [3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2]
        H[np.ix_(ou, ou)] += J.T @ om @ J
        b[ou] += J.T @ om @ e
    H[:3], H[:, :3], b[:3] = 0, 0, 0
    H[:3, :3] = np.eye(3)
    suite = poses - np.linalg.solve(H, b).reshape(-1, 3)
    suite[:, 2] = np.arctan2(np.sin(suite[:, 2]), np.cos(suite[:, 2]))
    return gauss_newton_robuste(suite, aretes, delta, n_iter - 1)
