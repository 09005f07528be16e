"""The kernel min(1, delta / x²), with the weights of the last round; stops when a step is small."""
def ramene(a):
    return np.arctan2(np.sin(a), np.cos(a))


def erreur_et_jacobienne(n, x, i, j, z):
    c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
    Rt = np.array([[c, s], [-s, c]])
    d = x[j, :2] - x[i, :2]
    e = np.append(Rt @ d - z[:2], ramene(x[j, 2] - x[i, 2] - z[2]))
    J = np.zeros((3, 3 * n))
    J[:2, 3 * i : 3 * i + 2] = -Rt
    J[:2, 3 * i + 2] = np.array([[-s, c], [-c, -s]]) @ d
    J[2, 3 * i + 2] = -1
    J[:2, 3 * j : 3 * j + 2] = Rt
    J[2, 3 * j + 2] = 1
    return e, J


def dimension_noyau(poses, aretes):
    pere = list(range(len(poses)))

    def chef(k):
        while pere[k] != k:
            k = pere[k]
        return k

    for i, j, _, _ in aretes:
        pere[chef(i)] = chef(j)
    return 3 * len({chef(k) for k in range(len(poses))})


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    x, n = np.array(poses, dtype=float), len(poses)
    poids = np.ones(len(aretes))
    for _ in range(n_iter):
        H, b = np.zeros((3 * n, 3 * n)), np.zeros(3 * n)
        for k, (i, j, z, omega) in enumerate(aretes):
            e, J = erreur_et_jacobienne(n, x, i, j, z)
            poids[k] = min(1.0, delta / max(e @ omega @ e, 1e-12))
            H += poids[k] * J.T @ omega @ J
            b += poids[k] * J.T @ omega @ e
        pas = np.linalg.solve(H[3:, 3:], -b[3:]).reshape(-1, 3)
        x[1:] += pas
        x[1:, 2] = ramene(x[1:, 2])
        if np.abs(pas).max() < 1e-4:
            break
    return x, poids
