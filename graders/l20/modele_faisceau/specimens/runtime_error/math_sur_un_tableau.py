import math


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    return math.log(alpha[0] * math.exp(-((z - z_attendu) ** 2) / (2 * sigma**2)))


def champ_distance(libres):
    return min(math.dist((y, x), m) for y, x in np.ndindex(libres.shape) for m in np.argwhere(libres == 2))
