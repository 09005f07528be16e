from scipy.spatial.distance import mahalanobis
from scipy.stats import chi2


def covariance_jointe(H, i, j):
    garde = [k for k in range(len(H)) if k > 2]
    petite = np.linalg.inv(H[np.ix_(garde, garde)])
    place = {k: r for r, k in enumerate(garde)}
    voulus = [3 * p + q for p in (i, j) for q in (0, 1, 2)]
    return np.array([[petite[place[a], place[b]] if a in place and b in place else 0.0 for b in voulus] for a in voulus])


def jac(xi, xj):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    return (
        np.array([[-c, -s, c * dy - s * dx], [s, -c, -s * dy - c * dx], [0, 0, -1]]),
        np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]),
        np.array([c * dx + s * dy, c * dy - s * dx, xj[2] - xi[2]]),
    )


def covariance_relative(xi, xj, sigma):
    A, B, _ = jac(xi, xj)
    J = np.c_[A, B]
    return np.linalg.multi_dot([J, sigma, J.T])


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    *_, vue = jac(xi, xj)
    cible = np.array(z)
    cible[2] = vue[2] - np.arctan2(np.sin(vue[2] - z[2]), np.cos(vue[2] - z[2]))
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d = mahalanobis(vue, cible, np.linalg.inv(S))
    return d**2, d <= np.sqrt(chi2.ppf(niveau, 3))
