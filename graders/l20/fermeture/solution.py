from scipy.stats import chi2


def residu(xi, xj, z):
    """La pose xj vue depuis xi, moins la mesure."""
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    angle = xj[2] - xi[2] - z[2]
    return np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], np.pi - (np.pi - angle) % (2 * np.pi)])


def jacobienne(xi, xj):
    """Les dérivées du résidu par rapport aux deux poses, côte à côte : (3, 6)."""
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    B = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    A = -B
    A[0, 2], A[1, 2] = -s * dx + c * dy, -c * dx - s * dy
    return np.hstack([A, B])


def covariance_jointe(H, i, j):
    """La covariance des poses i et j dans le monde, la pose 0 étant connue exactement."""
    # On raye la pose 0 pour fixer la jauge, on inverse, et seulement ensuite on extrait.
    tout = np.zeros(H.shape)
    tout[3:, 3:] = np.linalg.inv(H[3:, 3:])
    k = [3 * i, 3 * i + 1, 3 * i + 2, 3 * j, 3 * j + 1, 3 * j + 2]
    return tout[np.ix_(k, k)]


def covariance_relative(xi, xj, sigma):
    """La covariance de la pose j vue depuis i : ce que les deux ont d'erreur en commun disparaît."""
    J = jacobienne(xi, xj)
    return J @ sigma @ J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    """L'écart rapporté à ce qui l'explique, et s'il passe la porte."""
    e = residu(xi, xj, z)
    # Le doute des poses et celui de la mesure s'ajoutent : deux covariances.
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = e @ np.linalg.solve(S, e)
    return d2, d2 <= chi2.ppf(niveau, 3)
