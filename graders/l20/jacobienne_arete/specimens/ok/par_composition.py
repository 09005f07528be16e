"""Composition and inverse of poses; the residual is the relative pose less the measurement."""


def composer(a, b):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([a[0] + c * b[0] - s * b[1], a[1] + s * b[0] + c * b[1], a[2] + b[2]])


def inverse(a):
    c, s = np.cos(a[2]), np.sin(a[2])
    return np.array([-c * a[0] - s * a[1], s * a[0] - c * a[1], -a[2]])


def residu(xi, xj, z):
    e = composer(inverse(xi), xj) - z
    e[2] = np.angle(np.exp(1j * e[2]))
    return e


def jacobiennes(xi, xj, z):
    vu = composer(inverse(xi), xj)
    c, s = np.cos(-xi[2]), np.sin(-xi[2])
    B = np.eye(3)
    B[:2, :2] = [[c, -s], [s, c]]
    A = -B.copy()
    A[0, 2], A[1, 2] = vu[1], -vu[0]
    return A, B


def contribution(xi, xj, z, omega):
    J = np.column_stack(jacobiennes(xi, xj, z))
    poids = J.T @ omega
    return poids @ J, poids @ residu(xi, xj, z)
