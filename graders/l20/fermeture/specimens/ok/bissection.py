"""The threshold found by bisection of the law in closed form for three degrees."""
from math import erf, exp, pi, sqrt


def repartition(x):
    return erf(sqrt(x / 2)) - sqrt(2 * x / pi) * exp(-x / 2)


def quantile(p):
    bas, haut = 0.0, 1000.0
    for _ in range(100):
        milieu = (bas + haut) / 2
        if repartition(milieu) < p:
            bas = milieu
        else:
            haut = milieu
    return haut


def covariance_jointe(H, i, j):
    tout = np.zeros(np.shape(H))
    valeurs, vecteurs = np.linalg.eigh(H[3:, 3:])
    tout[3:, 3:] = vecteurs @ np.diag(1 / valeurs) @ vecteurs.T
    P = np.zeros((6, len(H)))
    for r in range(3):
        P[r, 3 * i + r] = 1
        P[3 + r, 3 * j + r] = 1
    return P @ tout @ P.T


def covariance_relative(xi, xj, sigma):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    J = np.zeros((3, 6))
    J[:2, :2] = [[-c, -s], [s, -c]]
    J[:, 3:] = -J[:, :3]
    J[:2, 2] = [-s * (xj[0] - xi[0]) + c * (xj[1] - xi[1]), -c * (xj[0] - xi[0]) - s * (xj[1] - xi[1])]
    J[2, 2], J[2, 5] = -1, 1
    return J @ sigma @ J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    e = [c * (xj[0] - xi[0]) + s * (xj[1] - xi[1]) - z[0], -s * (xj[0] - xi[0]) + c * (xj[1] - xi[1]) - z[1]]
    a = xj[2] - xi[2] - z[2]
    e.append(a - 2 * pi * np.floor((a + pi) / (2 * pi)))
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = np.dot(e, np.linalg.lstsq(S, np.array(e), rcond=None)[0])
    return (d2, 1.0) if d2 <= quantile(niveau) else (d2, 0.0)
