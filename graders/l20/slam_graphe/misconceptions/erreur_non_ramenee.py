def erreur(xi, xj, z):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    return np.array([c * dx + s * dy - z[0], -s * dx + c * dy - z[1], xj[2] - xi[2] - z[2]])
