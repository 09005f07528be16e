"""Finite differences on the right, step 1e-6."""
import math


def residu(xi, xj, z):
    c, s = math.cos(xi[2]), math.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    a = xj[2] - xi[2] - z[2]
    return np.array([c * dx + s * dy - z[0], c * dy - s * dx - z[1], math.atan2(math.sin(a), math.cos(a))])


def jacobiennes(xi, xj, z):
    h, e = 1e-6, residu(xi, xj, z)
    A, B = np.zeros((3, 3)), np.zeros((3, 3))
    for k in range(3):
        pi, pj = xi.copy(), xj.copy()
        pi[k] += h
        pj[k] += h
        A[:, k] = (residu(pi, xj, z) - e) / h
        B[:, k] = (residu(xi, pj, z) - e) / h
    return A, B


def contribution(xi, xj, z, omega):
    A, B = jacobiennes(xi, xj, z)
    J = np.concatenate((A, B), axis=1)
    return J.T @ omega @ J, J.T @ omega @ residu(xi, xj, z)
