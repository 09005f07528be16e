def covariance_jointe(H, i, j):
    return np.eye(6)


def covariance_relative(xi, xj, sigma):
    return np.eye(3)


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    return 0.0, True
