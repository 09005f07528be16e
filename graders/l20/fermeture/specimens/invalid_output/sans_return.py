def covariance_jointe(H, i, j):
    np.linalg.inv(H[3:, 3:])


def covariance_relative(xi, xj, sigma):
    sigma[:3, :3]


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    print("acceptée")
