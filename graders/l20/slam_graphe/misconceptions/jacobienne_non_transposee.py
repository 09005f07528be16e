def jacobiennes(xi, xj):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    par_xi = [[-c, s, -s * dx + c * dy], [-s, -c, -c * dx - s * dy], [0.0, 0.0, -1.0]]
    par_xj = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]
    return par_xi, par_xj
