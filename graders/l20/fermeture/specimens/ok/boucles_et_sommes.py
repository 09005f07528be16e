import numpy
from scipy.stats import chi2


def covariance_jointe(H, i, j):
    inverse = numpy.linalg.inv(H[3:, 3:])
    sortie = numpy.zeros((6, 6))
    for r in range(6):
        for c in range(6):
            a = 3 * (i if r < 3 else j) + r % 3 - 3
            b = 3 * (i if c < 3 else j) + c % 3 - 3
            if a >= 0 and b >= 0:
                sortie[r, c] = inverse[a, b]
    return sortie


def covariance_relative(xi, xj, sigma):
    c, s = numpy.cos(xi[2]), numpy.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    J = [[-c, -s, c * dy - s * dx, c, s, 0], [s, -c, -c * dx - s * dy, -s, c, 0], [0, 0, -1, 0, 0, 1]]
    sortie = numpy.zeros((3, 3))
    for a in range(3):
        for b in range(3):
            for k in range(6):
                for l in range(6):
                    sortie[a, b] += J[a][k] * sigma[k, l] * J[b][l]
    return sortie


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    c, s = numpy.cos(xi[2]), numpy.sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    angle = xj[2] - xi[2] - z[2]
    if angle > numpy.pi or angle < -numpy.pi:
        angle = (angle + numpy.pi) % (2 * numpy.pi) - numpy.pi
    e = numpy.array([c * dx + s * dy - z[0], c * dy - s * dx - z[1], angle])
    poids = numpy.linalg.inv(covariance_relative(xi, xj, sigma) + numpy.linalg.inv(omega))
    d2 = 0
    for a in range(3):
        for b in range(3):
            d2 += e[a] * poids[a, b] * e[b]
    if d2 > chi2.ppf(niveau, 3):
        return d2, False
    return d2, True
