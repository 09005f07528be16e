"""Systems instead of inverses."""
from scipy.stats import chi2


def residu(xi, xj, z):
    R = np.array([[np.cos(xi[2]), -np.sin(xi[2])], [np.sin(xi[2]), np.cos(xi[2])]])
    e = np.append(R.T @ (xj[:2] - xi[:2]) - z[:2], xj[2] - xi[2] - z[2])
    e[2] = np.arctan2(np.sin(e[2]), np.cos(e[2]))
    return e


def covariance_jointe(H, i, j):
    n = len(H)
    libre = np.linalg.solve(H[3:, 3:], np.eye(n - 3))
    tout = np.pad(libre, ((3, 0), (3, 0)))
    k = list(range(3 * i, 3 * i + 3)) + list(range(3 * j, 3 * j + 3))
    return tout[k][:, k]


def covariance_relative(xi, xj, sigma):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    u, v = c * (xj[0] - xi[0]) + s * (xj[1] - xi[1]), c * (xj[1] - xi[1]) - s * (xj[0] - xi[0])
    J = np.array([[-c, -s, v, c, s, 0], [s, -c, -u, -s, c, 0], [0, 0, -1, 0, 0, 1]])
    return J @ sigma @ J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    e = residu(xi, xj, z)
    S = covariance_relative(xi, xj, sigma) + np.linalg.solve(omega, np.eye(3))
    d2 = e.dot(np.linalg.solve(S, e))
    return d2, bool(d2 < chi2.ppf(niveau, 3))
