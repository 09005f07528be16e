def erreur(xi, xj, z):
    return relatif(relatif(xi, xj), z)
