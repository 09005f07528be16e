"""The derivative left to scipy, six unknowns at once."""
from scipy.optimize import approx_fprime


def residu(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    x, y = np.dot([[c, s], [-s, c]], np.subtract(xj, xi)[:2])
    angle = float(xj[2]) - float(xi[2]) - float(z[2])
    tours = round(angle / (2 * np.pi))
    return np.array([x - z[0], y - z[1], angle - 2 * np.pi * tours])


def jacobiennes(xi, xj, z):
    x = np.concatenate([xi, xj])
    J = np.array([approx_fprime(x, lambda x, k=k: residu(x[:3], x[3:], z)[k], 1e-7) for k in range(3)])
    return np.split(J, 2, axis=1)


def contribution(xi, xj, z, omega):
    J = np.concatenate(jacobiennes(xi, xj, z), axis=1)
    e = residu(xi, xj, z)
    H = sum(omega[k, l] * np.outer(J[k], J[l]) for k in range(3) for l in range(3))
    b = sum(omega[k, l] * J[k] * e[l] for k in range(3) for l in range(3))
    return H, b
