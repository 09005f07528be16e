def erreur(xi, xj, z):
    e = xj - xi - z
    e[2] = ramener(e[2])
    return e
