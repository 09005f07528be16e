def systeme(x, aretes):
    H, b, carres = np.zeros((x.size, x.size)), np.zeros(x.size), []
    for i, j, z, om in aretes:
        c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
        R = np.array([[c, -s], [s, c]])
        d = x[j, :2] - x[i, :2]
        t = (x[j, 2] - x[i, 2] - z[2] + np.pi) % (2 * np.pi) - np.pi
        e = np.array([*(R.T @ d - z[:2]), t])
        J = np.zeros((3, x.size))
        J[:2, 3 * i : 3 * i + 2], J[:2, 3 * j : 3 * j + 2] = -R.T, R.T
        J[:2, 3 * i + 2] = np.array([[-s, c], [-c, -s]]) @ d
        J[2, 3 * i + 2], J[2, 3 * j + 2] = -1, 1
        H += J.T @ om @ J
        b += J.T @ om @ e
        carres.append(e @ om @ e)
    return H, b, np.array(carres)


def dimension_noyau(poses, aretes):
    H, _, _ = systeme(poses, aretes)
    valeurs = np.sort(np.abs(np.linalg.eigvalsh(H)))
    # Le plus grand saut, en ordre de grandeur, sépare les valeurs nulles des autres.
    return int(np.argmax(np.diff(np.log(valeurs + 1e-13)))) + 1


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    """On relâche le seuil au début, on rejette franchement à la fin."""
    x = poses.copy()
    croit = np.ones(len(aretes), dtype=bool)
    for tour in range(n_iter):
        _, _, carres = systeme(x, aretes)
        seuil = delta * (8 if tour < 5 else 4 if tour < 10 else 2)
        croit = np.array([abs(a[1] - a[0]) == 1 for a in aretes]) | (carres < seuil**2)
        H, b, _ = systeme(x, [a for a, oui in zip(aretes, croit) if oui])
        x[1:] += np.linalg.solve(H[3:, 3:], -b[3:]).reshape(-1, 3)
        x[:, 2] = (x[:, 2] + np.pi) % (2 * np.pi) - np.pi
    return x, croit
