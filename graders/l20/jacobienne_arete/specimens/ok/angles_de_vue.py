"""By distance and bearing: where i sees j, then its derivatives along and across the line of sight."""
import numpy


def residu(xi, xj, z):
    rho = numpy.hypot(xj[0] - xi[0], xj[1] - xi[1])
    vue = numpy.arctan2(xj[1] - xi[1], xj[0] - xi[0]) - xi[2]
    angle = xj[2] - xi[2] - z[2]
    if angle > numpy.pi:
        angle = angle - 2 * numpy.pi
    if angle > numpy.pi:
        angle = angle - 2 * numpy.pi
    if angle < -numpy.pi:
        angle = angle + 2 * numpy.pi
    if angle < -numpy.pi:
        angle = angle + 2 * numpy.pi
    return numpy.array([rho * numpy.cos(vue) - z[0], rho * numpy.sin(vue) - z[1], angle])


def jacobiennes(xi, xj, z):
    rho = numpy.hypot(xj[0] - xi[0], xj[1] - xi[1])
    vue = numpy.arctan2(xj[1] - xi[1], xj[0] - xi[0]) - xi[2]
    est, nord = -xi[2], numpy.pi / 2 - xi[2]
    B = numpy.array([[numpy.cos(est), numpy.cos(nord), 0], [numpy.sin(est), numpy.sin(nord), 0], [0, 0, 1]])
    A = numpy.negative(B)
    A[:2, 2] = rho * numpy.sin(vue), -rho * numpy.cos(vue)
    return A, B


def contribution(xi, xj, z, omega):
    A, B = jacobiennes(xi, xj, z)
    e = residu(xi, xj, z)
    OA, OB = omega @ A, omega @ B
    H = numpy.vstack([numpy.hstack([A.T @ OA, A.T @ OB]), numpy.hstack([B.T @ OA, B.T @ OB])])
    return H, numpy.hstack([OA.T @ e, OB.T @ e])
