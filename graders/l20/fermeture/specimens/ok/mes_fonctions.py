"""With the functions of the exercise before."""
from mes_fonctions import jacobiennes, residu
from scipy.stats import chi2


def covariance_jointe(H, i, j):
    S = np.zeros_like(H)
    S[3:, 3:] = np.linalg.inv(H[3:, 3:])
    I, J = slice(3 * i, 3 * i + 3), slice(3 * j, 3 * j + 3)
    return np.block([[S[I, I], S[I, J]], [S[J, I], S[J, J]]])


def covariance_relative(xi, xj, sigma):
    J = np.hstack(jacobiennes(xi, xj, np.zeros(3)))
    return J @ sigma @ J.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    e = np.array(residu(xi, xj, z))
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = e @ np.linalg.inv(S) @ e
    return (d2, True) if d2 <= chi2.ppf(niveau, df=3) else (d2, False)
