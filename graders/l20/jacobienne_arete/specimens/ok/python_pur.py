"""No numpy at all: loops over lists."""
from math import cos, floor, pi, sin


def residu(xi, xj, z):
    c, s = cos(xi[2]), sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    a = xj[2] - xi[2] - z[2]
    a -= 2 * pi * floor((a + pi) / (2 * pi))
    return [c * dx + s * dy - z[0], -s * dx + c * dy - z[1], a]


def jacobiennes(xi, xj, z):
    c, s = cos(xi[2]), sin(xi[2])
    dx, dy = xj[0] - xi[0], xj[1] - xi[1]
    A = [[-c, -s, -s * dx + c * dy], [s, -c, -c * dx - s * dy], [0, 0, -1]]
    B = [[c, s, 0], [-s, c, 0], [0, 0, 1]]
    return A, B


def contribution(xi, xj, z, omega):
    A, B = jacobiennes(xi, xj, z)
    J = [A[k] + B[k] for k in range(3)]
    e = residu(xi, xj, z)
    H = [[0.0] * 6 for _ in range(6)]
    b = [0.0] * 6
    for r in range(6):
        for k in range(3):
            for l in range(3):
                b[r] += J[k][r] * omega[k][l] * e[l]
                for q in range(6):
                    H[r][q] += J[k][r] * omega[k][l] * J[l][q]
    return H, b
