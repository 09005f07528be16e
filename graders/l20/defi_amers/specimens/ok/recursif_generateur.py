import math


def erreur_et_jacobienne(depart, but, z):
    """La jacobienne (len(z), 3 + len(but)), à la main, ligne par ligne."""
    x, y, t = depart
    c, s = math.cos(t), math.sin(t)
    u = c * (but[0] - x) + s * (but[1] - y)
    v = -s * (but[0] - x) + c * (but[1] - y)
    e = [u - z[0], v - z[1]]
    lignes = [[-c, -s, v, c, s], [s, -c, -u, -s, c]]
    if len(z) == 3:
        e.append(math.remainder(but[2] - t - z[2], math.tau))
        lignes = [[*ligne, 0.0] for ligne in lignes] + [[0, 0, -1, 0, 0, 1]]
    return np.array(e), np.array(lignes)


def contributions(poses, amers, aretes, observations):
    base = 3 * len(poses)
    yield from (([*range(3 * i, 3 * i + 3), *range(3 * j, 3 * j + 3)], w, erreur_et_jacobienne(poses[i], poses[j], z)) for i, j, z, w in aretes)
    yield from (([*range(3 * i, 3 * i + 3), base + 2 * j, base + 2 * j + 1], w, erreur_et_jacobienne(poses[i], amers[j], z)) for i, j, z, w in observations)


def systeme(poses, amers, aretes, observations):
    N = 3 * len(poses) + 2 * len(amers)
    H, b = np.zeros((N, N)), np.zeros((N, 1))
    for indices, w, (e, J) in contributions(poses, amers, aretes, observations):
        H[np.ix_(indices, indices)] += J.T @ w @ J
        b[indices, 0] += J.T @ w @ e
    return (H, -b)


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    if n_iter == 0:
        return poses, amers
    H, second = systeme(poses, amers, aretes, observations)
    H[np.arange(3), np.arange(3)] += 1e12
    pas = np.linalg.solve(H, second).ravel()
    cut = 3 * len(poses)
    poses = [[p[0] + d[0], p[1] + d[1], math.remainder(p[2] + d[2], math.tau)] for p, d in zip(poses, pas[:cut].reshape(-1, 3))]
    amers = [[a[0] + d[0], a[1] + d[1]] for a, d in zip(amers, pas[cut:].reshape(-1, 2))]
    return slam_amers(poses, amers, aretes, observations, n_iter - 1)
