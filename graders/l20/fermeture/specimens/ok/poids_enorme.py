"""The first pose held by an enormous weight, then told to be certain."""
from scipy.stats import chi2


def ramener(a):
    while a > np.pi:
        a -= 2 * np.pi
    while a <= -np.pi:
        a += 2 * np.pi
    return a


def covariance_jointe(H, i, j):
    M = H.copy()
    M[:3, :3] += 1e14 * np.eye(3)
    S = np.linalg.inv(M)
    S[:3, :] = 0
    S[:, :3] = 0
    rangs = np.concatenate([3 * i + np.arange(3), 3 * j + np.arange(3)])
    return S[rangs[:, None], rangs[None, :]]


def derivees(xi, xj):
    Rt = np.array([[np.cos(xi[2]), np.sin(xi[2])], [-np.sin(xi[2]), np.cos(xi[2])]])
    dRt = np.array([[-np.sin(xi[2]), np.cos(xi[2])], [-np.cos(xi[2]), -np.sin(xi[2])]])
    A, B = -np.eye(3), np.eye(3)
    A[:2, :2], A[:2, 2], B[:2, :2] = -Rt, dRt @ (xj - xi)[:2], Rt
    return A, B


def covariance_relative(xi, xj, sigma):
    A, B = derivees(xi, xj)
    ii, ij, ji, jj = sigma[:3, :3], sigma[:3, 3:], sigma[3:, :3], sigma[3:, 3:]
    return A @ ii @ A.T + A @ ij @ B.T + B @ ji @ A.T + B @ jj @ B.T


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    _, B = derivees(xi, xj)
    e = B @ (xj - xi) - z
    e[2] = ramener(e[2])
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = np.trace(np.linalg.inv(S) @ np.outer(e, e))
    return d2, int(d2 <= chi2.ppf(niveau, 3))
