from dataclasses import dataclass


@dataclass
class Faisceau:
    sigma: float
    z_max: float
    alpha: np.ndarray
    lam: float

    def echo(self, z, m):
        return np.exp(-0.5 * ((z - m) / self.sigma) ** 2) / (self.sigma * (2 * np.pi) ** 0.5)

    def imprevu(self, z, m):
        return (z <= m) * self.lam * np.exp(-self.lam * z)

    def rien(self, z, m):
        return np.where(z < self.z_max, 0.0, 1.0)

    def hasard(self, z, m):
        return np.full_like(z, 1 / self.z_max)

    def __call__(self, z, m):
        causes = (self.echo, self.imprevu, self.rien, self.hasard)
        return sum(a * f(z, m) for a, f in zip(self.alpha, causes))


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    return np.log(Faisceau(sigma, z_max, alpha, lam)(z, z_attendu)).sum()


def champ_distance(libres):
    from scipy.spatial.distance import cdist

    cases = np.array([(y, x) for y in range(libres.shape[0]) for x in range(libres.shape[1])])
    return cdist(cases, np.argwhere(~libres)).min(axis=1).reshape(libres.shape)
