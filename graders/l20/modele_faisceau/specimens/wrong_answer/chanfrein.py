from math import exp, log, pi, sqrt


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    p = alpha[0] * np.exp(-((z - z_attendu) ** 2) / (2 * sigma**2)) / (sigma * sqrt(2 * pi))
    p += alpha[1] * lam * np.exp(-lam * z) * (z <= z_attendu) + alpha[2] * (z >= z_max) + alpha[3] / z_max
    return np.log(p).sum()


def champ_distance(libres):
    h, w = libres.shape
    d = np.where(libres, 1e9, 0.0)
    for _ in range(h + w):
        for y in range(h):
            for x in range(w):
                for j in (y - 1, y, y + 1):
                    for i in (x - 1, x, x + 1):
                        if 0 <= j < h and 0 <= i < w:
                            d[y, x] = min(d[y, x], d[j, i] + sqrt((y - j) ** 2 + (x - i) ** 2))
    return d
