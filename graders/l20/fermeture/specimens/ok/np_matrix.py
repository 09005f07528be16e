from scipy.stats import chi2


def covariance_jointe(H, i, j):
    libre = np.matrix(H)[3:, 3:].I
    tout = np.matrix(np.zeros(H.shape))
    tout[3:, 3:] = libre
    lignes = np.vstack([tout[3 * i : 3 * i + 3], tout[3 * j : 3 * j + 3]])
    return np.hstack([lignes[:, 3 * i : 3 * i + 3], lignes[:, 3 * j : 3 * j + 3]])


def covariance_relative(xi, xj, sigma):
    R = np.matrix([[np.cos(xi[2]), -np.sin(xi[2])], [np.sin(xi[2]), np.cos(xi[2])]])
    vu = np.asarray(R.T * np.matrix(xj[:2] - xi[:2]).T).ravel()
    J = np.matrix(np.zeros((3, 6)))
    J[:2, :2], J[:2, 3:5] = -R.T, R.T
    J[0, 2], J[1, 2], J[2, 2], J[2, 5] = vu[1], -vu[0], -1, 1
    return J * np.matrix(sigma) * J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    R = np.array([[np.cos(xi[2]), -np.sin(xi[2])], [np.sin(xi[2]), np.cos(xi[2])]])
    a = xj[2] - xi[2] - z[2]
    e = np.matrix([*((xj[:2] - xi[:2]) @ R - z[:2]), np.arctan2(np.sin(a), np.cos(a))]).T
    S = covariance_relative(xi, xj, sigma) + np.matrix(omega).I
    d2 = (e.T * S.I * e)[0, 0]
    return d2, np.less_equal(d2, chi2.ppf(niveau, 3))
