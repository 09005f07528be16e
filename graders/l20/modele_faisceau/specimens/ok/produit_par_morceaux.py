def densite(z, m, sigma, z_max, alpha, lam):
    p = alpha[0] * np.exp(-((z - m) ** 2) / (2 * sigma**2)) / (np.sqrt(2 * np.pi) * sigma)
    p += np.where(z <= m, alpha[1] * lam * np.exp(-lam * z), 0)
    p += np.where(z >= z_max, alpha[2], 0)
    return p + alpha[3] / z_max


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    p = densite(z, z_attendu, sigma, z_max, alpha, lam)
    total = 0
    for debut in range(0, len(p), 10):
        total += np.log(np.prod(p[debut:debut + 10]))
    return np.array(total)


def champ_distance(libres):
    # Une vague : de la plus petite distance à la plus grande.
    h, w = libres.shape
    ecarts = sorted((np.hypot(a, b), a, b) for a in range(-h, h + 1) for b in range(-w, w + 1))
    champ = np.full((h, w), np.nan)
    for y in range(h):
        for x in range(w):
            champ[y, x] = next(
                d for d, a, b in ecarts if 0 <= y + a < h and 0 <= x + b < w and not libres[y + a, x + b]
            )
    return champ
