from functools import partial, reduce
from operator import add


def erreur(x, arete):
    i, j, z, _ = arete
    a, b = x[i], x[j]
    c, s = np.cos(a[2]), np.sin(a[2])
    t = b[2] - a[2] - z[2]
    return np.array([[c, s], [-s, c]]) @ (b[:2] - a[:2]) - z[:2], np.arctan2(np.sin(t), np.cos(t))


def blanchie(x, arete):
    d, t = erreur(x, arete)
    e = np.append(d, t)
    return float(np.sqrt(e @ arete[3] @ e))


tukey = lambda r, c: (1 - (r / c) ** 2) ** 2 if r < c else 0.0


def contribution(x, arete_et_poids):
    arete, w = arete_et_poids
    i, j, z, om = arete
    c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
    d, t = erreur(x, arete)
    vu = d + z[:2]
    J = np.zeros((3, x.size))
    J[:, 3 * i : 3 * i + 3] = [[-c, -s, vu[1]], [s, -c, -vu[0]], [0, 0, -1]]
    J[:, 3 * j : 3 * j + 3] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
    return np.column_stack([w * J.T @ om @ J, w * J.T @ om @ np.append(d, t)])


def dimension_noyau(poses, aretes):
    total = reduce(add, map(partial(contribution, poses), ((a, 1.0) for a in aretes)))
    return len(total) - np.linalg.matrix_rank(total[:, :-1], tol=1e-6)


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    # Tukey avec le seuil usuel, plus de deux fois celui de Huber ; l'odométrie garde tout son poids.
    peser = lambda x: [1.0 if abs(a[0] - a[1]) == 1 else tukey(blanchie(x, a), 2.34 * delta) for a in aretes]

    def tour(x, _):
        total = reduce(add, map(partial(contribution, x), zip(aretes, peser(x))))
        x = x - np.append(np.zeros(3), np.linalg.solve(total[3:, 3:-1], total[3:, -1])).reshape(-1, 3)
        return np.column_stack([x[:, :2], np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))])

    x = reduce(tour, range(n_iter), poses)
    return x, peser(x)
