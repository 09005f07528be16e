"""Forward differences, dense blocks, a heavy weight on the first pose; the error is the pose seen from the measured one."""


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    angle = a[2] + b[2]
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], np.arctan2(np.sin(angle), np.cos(angle))])


def inverse(a):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])


def erreur(xi, xj, z):
    return composer(inverse(z), composer(inverse(xi), xj))


def gauss_newton(poses, aretes, n_iter=10):
    x = poses.copy()
    n = len(x)
    h = 1e-6
    for iteration in range(n_iter):
        H = np.zeros((3 * n, 3 * n))
        b = np.zeros(3 * n)
        chi2 = 0
        for i, j, z, omega in aretes:
            e = erreur(x[i], x[j], z)
            chi2 += e @ omega @ e
            A, B = np.zeros((3, 3)), np.zeros((3, 3))
            for k in range(3):
                d = np.zeros(3)
                d[k] = h
                A[:, k] = (erreur(x[i] + d, x[j], z) - e) / h
                B[:, k] = (erreur(x[i], x[j] + d, z) - e) / h
            I, J = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
            H[I, I] += A.T @ omega @ A
            H[I, J] += A.T @ omega @ B
            H[J, I] += B.T @ omega @ A
            H[J, J] += B.T @ omega @ B
            b[I] += A.T @ omega @ e
            b[J] += B.T @ omega @ e
        print("iteration", iteration, "chi2", chi2)
        H[:3, :3] += 1e9 * np.eye(3)
        x += np.linalg.solve(H, -b).reshape(n, 3)
        x[:, 2] = np.arctan2(np.sin(x[:, 2]), np.cos(x[:, 2]))
    return x
