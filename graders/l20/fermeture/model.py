from scipy.special import gammaincinv


def residu(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    angle = xj[2] - xi[2] - z[2]
    return np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], np.pi - (np.pi - angle) % (2 * np.pi)])


def covariance_jointe(H, i, j):
    tout = np.zeros(H.shape)
    tout[3:, 3:] = np.linalg.inv(H[3:, 3:])
    k = np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
    return tout[np.ix_(k, k)]


def covariance_relative(xi, xj, sigma):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    B = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    cap = np.array([-s * dx + c * dy, -c * dx - s * dy, -1.0])
    A = np.column_stack([-B[:, :2], cap])
    J = np.hstack([A, B])
    return J @ sigma @ J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    e = residu(xi, xj, z)
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = e @ np.linalg.inv(S) @ e
    seuil = 2 * gammaincinv(3 / 2, niveau)
    return d2, d2 <= seuil
