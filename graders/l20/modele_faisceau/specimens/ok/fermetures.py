gauss = lambda z, m, s: np.exp(-0.5 * ((z - m) / s) ** 2) / (s * np.sqrt(2 * np.pi))
expo = lambda z, lam: lam / np.exp(lam * z)


def log_vraisemblance(z, m, s, zm, a, lam):
    return np.sum(np.log(sum(
        part * cause
        for part, cause in zip(a, (gauss(z, m, s), expo(z, lam) * np.less_equal(z, m), np.greater_equal(z, zm), 1 / zm))
    )))


def champ_distance(carte):
    h, w = carte.shape
    plus_proche = lambda y, x: np.linalg.norm(np.argwhere(~carte) - [y, x], axis=1).min()
    return np.fromfunction(np.vectorize(plus_proche), (h, w))
