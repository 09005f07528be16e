"""Central differences of the residual of a measurement of zero."""
from scipy.stats import chi2


def ecart(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    R = np.array([[c, s], [-s, c]])
    t = R @ (np.asarray(xj[:2]) - np.asarray(xi[:2])) - np.asarray(z[:2])
    angle = (xj[2] - xi[2] - z[2] + np.pi) % (2 * np.pi) - np.pi
    return np.append(t, angle)


def jacobienne(xi, xj, pas=1e-6):
    deux = np.concatenate([xi, xj])
    colonnes = []
    for k in range(6):
        d = np.zeros(6)
        d[k] = pas
        plus, moins = deux + d, deux - d
        colonnes.append((ecart(plus[:3], plus[3:], (0, 0, 0)) - ecart(moins[:3], moins[3:], (0, 0, 0))) / (2 * pas))
    return np.array(colonnes).T


def covariance_jointe(H, i, j):
    libre = np.linalg.inv(H[3:, 3:])
    toutes = np.zeros_like(H)
    toutes[3:, 3:] = libre
    places = [*range(3 * i, 3 * i + 3), *range(3 * j, 3 * j + 3)]
    return toutes[places][:, places]


def covariance_relative(xi, xj, sigma):
    J = jacobienne(xi, xj)
    return J @ sigma @ J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    e = ecart(xi, xj, z)
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = float(e @ np.linalg.inv(S) @ e)
    return [d2, 1 if d2 <= chi2.ppf(niveau, 3) else 0]
