import g2o_absent


def erreur(xi, xj, z):
    return g2o_absent.erreur(xi, xj, z)
