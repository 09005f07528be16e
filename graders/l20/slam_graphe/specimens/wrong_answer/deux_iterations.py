"""Right steps, but two of them only, whatever n_iter."""


def ramener(t):
    return (t + np.pi) % (2 * np.pi) - np.pi


def erreur(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    d = xj - xi
    return np.array([c * d[0] + s * d[1] - z[0], -s * d[0] + c * d[1] - z[1], ramener(d[2] - z[2])])


def gauss_newton(poses, aretes, n_iter=10):
    x = poses.copy()
    for _ in range(2):
        H, b = np.zeros((x.size, x.size)), np.zeros(x.size)
        for i, j, z, om in aretes:
            c, s = np.cos(x[i, 2]), np.sin(x[i, 2])
            d = x[j] - x[i]
            J = np.zeros((3, x.size))
            J[:, 3 * i : 3 * i + 3] = [[-c, -s, -s * d[0] + c * d[1]], [s, -c, -c * d[0] - s * d[1]], [0, 0, -1]]
            J[:, 3 * j : 3 * j + 3] = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
            H += J.T @ om @ J
            b += J.T @ om @ erreur(x[i], x[j], z)
        x[1:] -= np.linalg.solve(H[3:, 3:], b[3:]).reshape(-1, 3)
        x[:, 2] = ramener(x[:, 2])
    return x
