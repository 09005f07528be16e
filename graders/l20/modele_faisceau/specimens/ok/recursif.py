from functools import reduce
from math import dist, erf, exp, log, pi, sqrt


def p(z, m, s, z_max, alpha, lam):
    h, c, x, r = alpha
    return h * exp(-((z - m) ** 2) / 2 / s**2) / s / sqrt(2 * pi) + c * lam * exp(-lam * z) * (z <= m) + x * (
        z >= z_max
    ) + r / z_max


def log_vraisemblance(z, z_attendu, *reglages):
    if len(z) == 1:
        return log(p(z[0], z_attendu[0], *reglages))
    milieu = len(z) // 2
    return log_vraisemblance(z[:milieu], z_attendu[:milieu], *reglages) + log_vraisemblance(
        z[milieu:], z_attendu[milieu:], *reglages
    )


def champ_distance(libres):
    murs = [tuple(m) for m in np.argwhere(~libres)]
    return [
        [reduce(min, (dist((y, x), m) for m in murs)) for x in range(len(libres[0]))] for y in range(len(libres))
    ]
