"""Right values, but the information given is emptied."""
from mes_fonctions import jacobiennes, residu
from scipy.stats import chi2


def covariance_jointe(H, i, j):
    H[3:, 3:] = np.linalg.inv(H[3:, 3:])
    H[:3, :] = 0
    H[:, :3] = 0
    k = np.r_[3 * i : 3 * i + 3, 3 * j : 3 * j + 3]
    return H[np.ix_(k, k)]


def covariance_relative(xi, xj, sigma):
    J = np.hstack(jacobiennes(xi, xj, np.zeros(3)))
    return J @ sigma @ J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    e = np.array(residu(xi, xj, z))
    d2 = e @ np.linalg.inv(covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)) @ e
    return d2, d2 <= chi2.ppf(niveau, 3)
