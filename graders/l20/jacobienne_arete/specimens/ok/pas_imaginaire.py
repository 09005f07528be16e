"""The derivative by an imaginary step, exact to rounding."""


def brut(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    d = xj - xi
    return np.array([c * d[0] + s * d[1], c * d[1] - s * d[0], d[2]]) - z


def residu(xi, xj, z):
    e = brut(xi, xj, z)
    e[2] -= 2 * np.pi * np.ceil((e[2] - np.pi) / (2 * np.pi))
    return e


def jacobiennes(xi, xj, z):
    h = 1e-30
    A, B = np.empty((3, 3)), np.empty((3, 3))
    for k, u in enumerate(np.eye(3)):
        A[:, k] = brut(xi + 1j * h * u, xj, z).imag / h
        B[:, k] = brut(xi, xj + 1j * h * u, z).imag / h
    return A, B


def contribution(xi, xj, z, omega):
    J = np.c_[jacobiennes(xi, xj, z)]
    return np.einsum("ki,kl,lj->ij", J, omega, J), np.einsum("ki,kl,l->i", J, omega, residu(xi, xj, z))
