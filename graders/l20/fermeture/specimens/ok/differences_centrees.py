"""Jacobians by central differences; the survival function instead of a quantile."""
from scipy import stats


def vue(xi, xj):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    d = xj - xi
    return np.array([c * d[0] + s * d[1], -s * d[0] + c * d[1], d[2]])


def covariance_jointe(H, i, j):
    colonnes = np.zeros((len(H), 6))
    k = [3 * p + q for p in (i, j) for q in range(3)]
    for c, ligne in enumerate(k):
        if ligne >= 3:
            unite = np.zeros(len(H))
            unite[ligne] = 1
            colonnes[3:, c] = np.linalg.solve(H[3:, 3:], unite[3:])
    return colonnes[k]


def covariance_relative(xi, xj, sigma, h=1e-5):
    J = np.zeros((3, 6))
    for c in range(3):
        d = np.zeros(3)
        d[c] = h
        J[:, c] = (vue(xi + d, xj) - vue(xi - d, xj)) / (2 * h)
        J[:, 3 + c] = (vue(xi, xj + d) - vue(xi, xj - d)) / (2 * h)
    return J @ sigma @ J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    e = vue(xi, xj) - z
    e[2] = (e[2] + np.pi) % (2 * np.pi) - np.pi
    d2 = e @ np.linalg.inv(covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)) @ e
    return [d2, stats.chi2.sf(d2, 3) >= 1 - niveau]
