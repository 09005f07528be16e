_jacobiennes_entieres = jacobiennes


def jacobiennes(xi, xj):
    par_xi, par_xj = _jacobiennes_entieres(xi, xj)
    par_xi[0][2] = par_xi[1][2] = 0.0
    return par_xi, par_xj
