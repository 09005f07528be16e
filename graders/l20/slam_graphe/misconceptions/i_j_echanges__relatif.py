def erreur(xi, xj, z):
    return relatif(z, relatif(xj, xi))
