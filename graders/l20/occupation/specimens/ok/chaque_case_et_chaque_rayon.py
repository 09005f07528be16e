"""Every cell is asked how long each ray is in it (slabs); nothing is walked."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(l, pose, scan, portee_max):
    hauteur, largeur = l.shape
    i, j = np.mgrid[0:hauteur, 0:largeur]
    x, y, theta = pose
    somme = np.zeros(l.shape)
    for k, z in enumerate(scan):
        a = theta + 2 * np.pi * k / len(scan)
        u, v = np.cos(a) + 1e-13, np.sin(a) + 1e-13
        tx, ty = np.sort([(j - x) / u, (j + 1 - x) / u], axis=0), np.sort([(i - y) / v, (i + 1 - y) / v], axis=0)
        entre = np.maximum(np.maximum(tx[0], ty[0]), 0)
        sort = np.minimum(tx[1], ty[1])
        r = z + 1e-6
        mur = (entre <= r) & (r < sort) & (z < portee_max)
        traverse = (np.minimum(sort, min(z, portee_max)) - entre > 1e-6) & ~mur
        somme += 0.847 * mur - 0.847 * traverse
    return np.clip(l + somme, -5.0, 5.0)
