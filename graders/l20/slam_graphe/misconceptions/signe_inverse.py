def erreur(xi, xj, z):
    e = z - relatif(xi, xj)
    e[2] = ramener(e[2])
    return e
