def erreur(xi, xj, z):
    return relatif(xi, xj)
