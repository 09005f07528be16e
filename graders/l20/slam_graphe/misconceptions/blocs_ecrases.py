def gauss_newton(poses, aretes, n_iter=10):
    x = np.array(poses, dtype=float)
    n = x.size
    for _ in range(n_iter):
        H, b = np.zeros((n, n)), np.zeros(n)
        for i, j, z, omega in aretes:
            A, B = (np.array(bloc) for bloc in jacobiennes(x[i], x[j]))
            oA, oB = omega @ A, omega @ B
            e = erreur(x[i], x[j], z)
            si, sj = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
            H[si, si], H[si, sj], H[sj, si], H[sj, sj] = A.T @ oA, A.T @ oB, B.T @ oA, B.T @ oB
            b[si], b[sj] = oA.T @ e, oB.T @ e
        delta = np.zeros(n)
        delta[3:] = np.linalg.solve(H[3:, 3:], -b[3:])
        x = corriger(x, delta.reshape(-1, 3))
    return x
