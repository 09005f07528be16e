"""Homogeneous matrices, and the generator of rotations."""


def T(p):
    c, s = np.cos(p[2]), np.sin(p[2])
    return np.array([[c, -s, p[0]], [s, c, p[1]], [0.0, 0.0, 1.0]])


def residu(xi, xj, z):
    M = np.linalg.inv(T(xi)) @ T(xj)
    angle = np.arctan2(M[1, 0], M[0, 0]) - z[2]
    return np.array([M[0, 2] - z[0], M[1, 2] - z[1], np.arctan2(np.sin(angle), np.cos(angle))])


def jacobiennes(xi, xj, z):
    M = np.linalg.inv(T(xi)) @ T(xj)
    Rt = T(xi)[:2, :2].T
    G = np.array([[0.0, -1.0], [1.0, 0.0]])
    A, B = -np.eye(3), np.eye(3)
    A[:2, :2] = -Rt
    A[:2, 2] = -G @ M[:2, 2]
    B[:2, :2] = Rt
    return A, B


def contribution(xi, xj, z, omega):
    A, B = jacobiennes(xi, xj, z)
    e = residu(xi, xj, z)
    H = np.zeros((6, 6))
    H[:3, :3] = A.T @ omega @ A
    H[:3, 3:] = A.T @ omega @ B
    H[3:, :3] = H[:3, 3:].T
    H[3:, 3:] = B.T @ omega @ B
    b = np.zeros(6)
    b[:3] = A.T @ omega @ e
    b[3:] = B.T @ omega @ e
    return H, b
