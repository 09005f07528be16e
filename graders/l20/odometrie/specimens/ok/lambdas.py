"""Lambdas, and a modulo centred on zero."""
ramener = lambda a: (a + np.pi) % (2 * np.pi) - np.pi
odometrie = lambda p, g, d, L: np.array([
    p[0] + (g + d) / 2 * np.cos(p[2] + (d - g) / L / 2),
    p[1] + (g + d) / 2 * np.sin(p[2] + (d - g) / L / 2),
    ramener(p[2] + (d - g) / L),
])
sigma_dtheta = lambda a, b, L: (a * a + b * b) ** 0.5 / L
