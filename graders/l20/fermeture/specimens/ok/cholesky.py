"""Whitened errors: the square of a length."""
from scipy.linalg import cho_factor, cho_solve, solve_triangular
from scipy.stats import chi2


def covariance_jointe(H, i, j):
    facteur = cho_factor(H[3:, 3:])
    selection = np.zeros((len(H), 6))
    selection[3 * i : 3 * i + 3, :3] = np.eye(3)
    selection[3 * j : 3 * j + 3, 3:] = np.eye(3)
    libre = selection[3:]
    return libre.T @ cho_solve(facteur, libre)


def covariance_relative(xi, xj, sigma):
    t = xi[2]
    Rt = np.array([[np.cos(t), np.sin(t), 0], [-np.sin(t), np.cos(t), 0], [0, 0, 1]])
    levier = np.eye(3)
    levier[0, 2], levier[1, 2] = -(xj[1] - xi[1]), xj[0] - xi[0]
    # In the axes of the world first, then turned.
    D = np.hstack([-levier, np.eye(3)])
    return Rt @ (D @ sigma @ D.T) @ Rt.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    c, s = np.cos(xi[2]), np.sin(xi[2])
    e = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]]) @ (xj - xi) - z
    e[2] = np.angle(np.exp(1j * e[2]))
    L = np.linalg.cholesky(covariance_relative(xi, xj, sigma) + np.linalg.inv(omega))
    blanchi = solve_triangular(L, e, lower=True)
    return np.sum(blanchi**2), np.sum(blanchi**2) <= chi2.isf(1 - niveau, 3)
