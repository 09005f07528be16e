"""The other poses are eliminated; what is left is inverted."""
from scipy.stats import chi2


def covariance_jointe(H, i, j):
    voulus = [k for k in range(3, len(H)) if k // 3 in (i, j)]
    autres = [k for k in range(3, len(H)) if k // 3 not in (i, j)]
    reste = H[np.ix_(voulus, voulus)]
    if autres:
        lien = H[np.ix_(voulus, autres)]
        reste = reste - lien @ np.linalg.solve(H[np.ix_(autres, autres)], lien.T)
    S = np.zeros(H.shape)
    S[np.ix_(voulus, voulus)] = np.linalg.inv(reste)
    k = np.hstack([3 * i + np.arange(3), 3 * j + np.arange(3)])
    return S[np.ix_(k, k)]


def covariance_relative(xi, xj, sigma):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    x, y = xj[:2] - xi[:2]
    A = np.array([[-c, -s, -s * x + c * y], [s, -c, -c * x - s * y], [0, 0, -1]])
    B = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
    return np.concatenate([A, B], axis=1) @ sigma @ np.concatenate([A.T, B.T])


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    x, y = xj[:2] - xi[:2]
    tours = np.round((xj[2] - xi[2] - z[2]) / (2 * np.pi))
    e = np.array([c * x + s * y - z[0], c * y - s * x - z[1], xj[2] - xi[2] - z[2] - 2 * np.pi * tours])
    # By the lemma of inversion, when only the measurement has an inverse.
    P = covariance_relative(xi, xj, sigma)
    S_inverse = omega - omega @ P @ np.linalg.inv(np.eye(3) + omega @ P) @ omega
    d2 = e @ S_inverse @ e
    return d2, d2 <= chi2.ppf(niveau, 3)
