def cloche(z, attendu, sigma):
    return np.exp(-((z - attendu) ** 2) / (2 * sigma**2)) / (sigma * np.sqrt(2 * np.pi))


def court(z, attendu, lam):
    return lam * np.exp(-lam * z) * (z <= attendu)


def plein(z, z_max):
    return 1.0 * (z >= z_max)


def hasard(z, z_max):
    return np.ones(len(z)) / z_max


def log_vraisemblance(z, z_attendu, sigma, z_max, alpha, lam):
    hit, short, maxi, rand = alpha
    p = hit * cloche(z, z_attendu, sigma)
    p = p + short * court(z, z_attendu, lam)
    p = p + maxi * plein(z, z_max)
    p = p + rand * hasard(z, z_max)
    return np.sum(np.log(p))


def ecart(dx, dy):
    return np.sqrt(dx**2 + dy**2)


def champ_distance(libres):
    hauteur, largeur = libres.shape
    murs = np.argwhere(~libres)
    champ = np.zeros((hauteur, largeur))
    for y in range(hauteur):
        for x in range(largeur):
            dy, dx = murs[:, 0] - y, murs[:, 1] - x
            champ[y, x] = np.min(ecart(dx, dy))
    return champ
