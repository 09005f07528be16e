"""Homogeneous matrices, a namedtuple, and a rank among all poses."""
from collections import namedtuple

from scipy.stats import chi2

Avis = namedtuple("Avis", "d2 accepte")


def T(p):
    return np.array([[np.cos(p[2]), -np.sin(p[2]), p[0]], [np.sin(p[2]), np.cos(p[2]), p[1]], [0, 0, 1.0]])


def covariance_jointe(H, i, j):
    n = len(H) // 3
    inverse = np.linalg.inv(H[3:, 3:])
    blocs = {(a, b): inverse[3 * a - 3 : 3 * a, 3 * b - 3 : 3 * b] for a in range(1, n) for b in range(1, n)}
    nul = np.zeros((3, 3))
    return np.vstack([np.hstack([blocs.get((a, b), nul) for b in (i, j)]) for a in (i, j)])


def covariance_relative(xi, xj, sigma):
    M = np.linalg.inv(T(xi)) @ T(xj)
    Rt = T(xi)[:2, :2].T
    J = np.zeros((3, 6))
    J[:2, :2], J[:2, 2], J[:2, 3:5] = -Rt, [M[1, 2], -M[0, 2]], Rt
    J[2] = [0, 0, -1, 0, 0, 1]
    return J @ (J @ sigma).T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    M = np.linalg.inv(T(xi)) @ T(xj)
    E = T((0, 0, z[2])).T @ M
    e = np.array([M[0, 2] - z[0], M[1, 2] - z[1], np.arctan2(E[1, 0], E[0, 0])])
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = e @ np.linalg.pinv(S) @ e
    return Avis(d2, d2 <= chi2.ppf(niveau, 3))
