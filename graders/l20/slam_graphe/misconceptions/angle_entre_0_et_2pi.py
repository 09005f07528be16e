def erreur(xi, xj, z):
    e = relatif(xi, xj) - z
    e[2] = e[2] % (2 * np.pi)
    return e
