def erreur(xi, xj, z):
    r = relatif(xi, xj)
    return np.array([r[0] - z[0], r[1] - z[1], r[2]])
