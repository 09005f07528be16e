def erreur(xi, xj, z):
    return [xj[0] - xi[0], xj[1] - xi[1], xj[2] - xi[2]
