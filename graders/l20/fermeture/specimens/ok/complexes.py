"""The plane as complex numbers."""
import cmath

from scipy.special import gammainc


def covariance_jointe(H, i, j):
    libre = np.linalg.inv(H[3:, 3:])
    sortie = np.zeros((6, 6))
    for a, p in enumerate((i, j)):
        for b, q in enumerate((i, j)):
            if p and q:
                sortie[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] = libre[3 * p - 3 : 3 * p, 3 * q - 3 : 3 * q]
    return sortie


def covariance_relative(xi, xj, sigma):
    u = cmath.exp(-1j * xi[2])
    w = complex(xj[0] - xi[0], xj[1] - xi[1]) * u
    colonnes = [-u, -1j * u, -1j * w, u, 1j * u, 0]
    J = np.array([[complex(c).real for c in colonnes], [complex(c).imag for c in colonnes], [0, 0, -1, 0, 0, 1]])
    return J.dot(sigma).dot(J.T)


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    w = complex(xj[0] - xi[0], xj[1] - xi[1]) * cmath.exp(-1j * xi[2]) - complex(z[0], z[1])
    e = np.array([w.real, w.imag, cmath.phase(cmath.exp(1j * (xj[2] - xi[2] - z[2])))])
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = float(e @ np.linalg.inv(S) @ e)
    return d2, gammainc(1.5, d2 / 2) <= niveau
