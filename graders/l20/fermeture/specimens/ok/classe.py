from scipy.stats import chi2


class Fermeture:
    def __init__(self, xi, xj):
        self.xi, self.xj = xi, xj
        self.c, self.s = np.cos(xi[2]), np.sin(xi[2])
        d = xj - xi
        self.u, self.v, self.cap = self.c * d[0] + self.s * d[1], self.c * d[1] - self.s * d[0], d[2]

    @property
    def J(self):
        c, s = self.c, self.s
        return np.array([[-c, -s, self.v, c, s, 0], [s, -c, -self.u, -s, c, 0], [0, 0, -1, 0, 0, 1]])

    def ecart(self, z):
        a = self.cap - z[2]
        return np.array([self.u - z[0], self.v - z[1], np.pi - (np.pi - a) % (2 * np.pi)])


def covariance_jointe(H, i, j):
    sigma = np.zeros((len(H) // 3, 3, len(H) // 3, 3))
    sigma[1:, :, 1:, :] = np.linalg.inv(H[3:, 3:]).reshape(len(H) // 3 - 1, 3, len(H) // 3 - 1, 3)
    return sigma[[i, j]][:, :, [i, j]].reshape(6, 6)


def covariance_relative(xi, xj, sigma):
    J = Fermeture(xi, xj).J
    return np.einsum("ai,ij,bj->ab", J, sigma, J)


def juger_fermeture(xi, xj, z, sigma, omega, niveau=0.95):
    e = Fermeture(xi, xj).ecart(z)
    S = covariance_relative(xi, xj, sigma) + np.linalg.inv(omega)
    d2 = np.einsum("i,ij,j->", e, np.linalg.inv(S), e)
    return d2, not d2 > chi2.ppf(niveau, 3)
