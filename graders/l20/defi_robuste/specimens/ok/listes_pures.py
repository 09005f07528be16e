from math import atan2, cos, pi, remainder, sin, sqrt, tau


def mesurer(xi, xj, z):
    c, s = cos(xi[2]), sin(xi[2])
    u = c * (xj[0] - xi[0]) + s * (xj[1] - xi[1])
    v = c * (xj[1] - xi[1]) - s * (xj[0] - xi[0])
    e = (u - z[0], v - z[1], remainder(xj[2] - xi[2] - z[2], tau))
    return e, ((-c, -s, v, c, s, 0.0), (s, -c, -u, -s, c, 0.0), (0.0, 0.0, -1.0, 0.0, 0.0, 1.0))


def assembler(x, aretes, poids):
    N = 3 * len(x)
    H, b = [[0.0] * N for _ in range(N)], [0.0] * N
    for (i, j, z, om), w in zip(aretes, poids):
        e, J = mesurer(x[i], x[j], z)
        ou = [3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2]
        p = [w * float(om[k][k]) for k in range(3)]
        for r in range(6):
            b[ou[r]] += sum(J[k][r] * p[k] * e[k] for k in range(3))
            for c in range(6):
                H[ou[r]][ou[c]] += sum(J[k][r] * p[k] * J[k][c] for k in range(3))
    return H, b


def eliminer(M):
    """Élimination de Gauss ; renvoie la matrice échelonnée et les pivots."""
    M, rang = [ligne[:] for ligne in M], 0
    grand = max(abs(v) for ligne in M for v in ligne)
    for colonne in range(len(M)):
        k = max(range(rang, len(M)), key=lambda r: abs(M[r][colonne]), default=None)
        if k is None or abs(M[k][colonne]) < 1e-9 * grand:
            continue
        M[rang], M[k] = M[k], M[rang]
        for r in range(rang + 1, len(M)):
            f = M[r][colonne] / M[rang][colonne]
            if f:
                M[r] = [a - f * q for a, q in zip(M[r], M[rang])]
        rang += 1
    return M, rang


def dimension_noyau(poses, aretes):
    H, _ = assembler([list(map(float, p)) for p in poses], aretes, [1.0] * len(aretes))
    return len(H) - eliminer(H)[1]


def gauss_newton_robuste(poses, aretes, delta, n_iter):
    x = [list(map(float, p)) for p in poses]

    def peser():
        poids = []
        for i, j, z, om in aretes:
            e, _ = mesurer(x[i], x[j], z)
            norme = sqrt(sum(float(om[k][k]) * e[k] ** 2 for k in range(3)))
            poids.append(1.0 if norme < delta else delta / norme)
        return poids

    for _ in range(min(n_iter, 12)):
        H, b = assembler(x, aretes, peser())
        M, _ = eliminer([ligne[3:] + [-b[3 + k]] for k, ligne in enumerate(H[3:])] + [[0.0] * (len(H) - 2)])
        pas = [0.0] * (len(H) - 3)
        for k in reversed(range(len(pas))):
            pas[k] = (M[k][-1] - sum(M[k][c] * pas[c] for c in range(k + 1, len(pas)))) / M[k][k]
        for k in range(1, len(x)):
            x[k] = [x[k][0] + pas[3 * k - 3], x[k][1] + pas[3 * k - 2], remainder(x[k][2] + pas[3 * k - 1], tau)]
    return x, peser()
