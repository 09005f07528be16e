from math import atan2, cos, pi, sin


def produit(A, B):
    return [[sum(x * y for x, y in zip(ligne, colonne)) for colonne in zip(*B)] for ligne in A]


def transposee(A):
    return [list(ligne) for ligne in zip(*A)]


def mesures(poses, amers, aretes, observations):
    """Pour chaque mesure : les indices touchés, sa jacobienne, son poids, son erreur."""
    n = len(poses)
    for i, j, z, omega in aretes:
        xi, yi, t = poses[i]
        dx, dy = poses[j][0] - xi, poses[j][1] - yi
        c, s = cos(t), sin(t)
        a = poses[j][2] - t - z[2]
        e = [c * dx + s * dy - z[0], -s * dx + c * dy - z[1], atan2(sin(a), cos(a))]
        J = [[-c, -s, -s * dx + c * dy, c, s, 0], [s, -c, -c * dx - s * dy, -s, c, 0], [0, 0, -1, 0, 0, 1]]
        yield [3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2], J, omega.tolist(), e
    for i, j, z, omega in observations:
        xi, yi, t = poses[i]
        dx, dy = amers[j][0] - xi, amers[j][1] - yi
        c, s = cos(t), sin(t)
        J = [[-c, -s, -s * dx + c * dy, c, s], [s, -c, -c * dx - s * dy, -s, c]]
        k = 3 * n + 2 * j
        e = [c * dx + s * dy - z[0], -s * dx + c * dy - z[1]]
        yield [3 * i, 3 * i + 1, 3 * i + 2, k, k + 1], J, omega.tolist(), e


def systeme(poses, amers, aretes, observations):
    poses, amers = [list(map(float, p)) for p in poses], [list(map(float, a)) for a in amers]
    N = 3 * len(poses) + 2 * len(amers)
    H, b = [[0.0] * N for _ in range(N)], [0.0] * N
    for indices, J, omega, e in mesures(poses, amers, aretes, observations):
        JtW = produit(transposee(J), omega)
        M = produit(JtW, J)
        v = produit(JtW, [[x] for x in e])
        for r, p in enumerate(indices):
            b[p] += v[r][0]
            for c, q in enumerate(indices):
                H[p][q] += M[r][c]
    return H, b


def resoudre(A, y):
    """Élimination de Gauss avec pivot."""
    n = len(y)
    M = [ligne[:] + [y[k]] for k, ligne in enumerate(A)]
    for k in range(n):
        p = max(range(k, n), key=lambda r: abs(M[r][k]))
        M[k], M[p] = M[p], M[k]
        for r in range(k + 1, n):
            if M[r][k] != 0.0:
                f = M[r][k] / M[k][k]
                M[r] = [u - f * v for u, v in zip(M[r], M[k])]
    x = [0.0] * n
    for k in reversed(range(n)):
        x[k] = (M[k][n] - sum(M[k][c] * x[c] for c in range(k + 1, n))) / M[k][k]
    return x


def slam_amers(poses, amers, aretes, observations, n_iter=10):
    p, a = [list(map(float, x)) for x in poses], [list(map(float, x)) for x in amers]
    for _ in range(min(n_iter, 10)):
        H, b = systeme(p, a, aretes, observations)
        d = [0.0, 0.0, 0.0, *resoudre([ligne[3:] for ligne in H[3:]], [-v for v in b[3:]])]
        for i in range(len(p)):
            p[i] = [p[i][k] + d[3 * i + k] for k in range(3)]
            p[i][2] = atan2(sin(p[i][2]), cos(p[i][2]))
        for j in range(len(a)):
            a[j] = [a[j][k] + d[3 * len(p) + 2 * j + k] for k in range(2)]
        if max(map(abs, d)) < 1e-9:
            break
    return p, a
