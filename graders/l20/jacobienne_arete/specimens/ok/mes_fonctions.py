"""With the function of an earlier exercise."""
from mes_fonctions import relatif


def residu(xi, xj, z):
    e = np.array(relatif(xi, xj)) - z
    e[2] = np.pi - (np.pi - e[2]) % (2 * np.pi)
    return e


def jacobiennes(xi, xj, z):
    vu = relatif(xi, xj)
    u, v = vu[0], vu[1]
    Rt = np.array([[np.cos(xi[2]), np.sin(xi[2])], [-np.sin(xi[2]), np.cos(xi[2])]])
    A = np.zeros((3, 3))
    A[:2, :2], A[:, 2] = -Rt, (v, -u, -1)
    B = np.diag([0.0, 0.0, 1.0])
    B[:2, :2] = Rt
    return A, B


def contribution(xi, xj, z, omega):
    A, B = jacobiennes(xi, xj, z)
    e, J = residu(xi, xj, z), np.hstack((A, B))
    return np.matmul(np.matmul(J.T, omega), J), np.matmul(np.matmul(J.T, omega), e)
