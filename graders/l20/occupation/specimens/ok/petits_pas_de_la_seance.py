"""The lesson's own cell, with a copy and the edges looked at; the stopping cell is crossed, then stopped in."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def cases_du_rayon(x, y, angle, longueur):
    t = np.arange(0, longueur, 0.05)
    lignes = np.floor(y + t * np.sin(angle)).astype(int)
    colonnes = np.floor(x + t * np.cos(angle)).astype(int)
    return list(dict.fromkeys(zip(lignes, colonnes)))


def integrer_scan(l, pose, scan, portee_max):
    l = l.copy()
    h, w = l.shape
    x, y, theta = pose
    for k, z in enumerate(scan):
        angle = theta + 2 * np.pi * k / len(scan)
        for i, j in cases_du_rayon(x, y, angle, min(z, portee_max) - 1e-6):
            if 0 <= i < h and 0 <= j < w:
                l[i, j] -= 0.847
        if z < portee_max:
            r = z + 1e-6
            i, j = int(np.floor(y + r * np.sin(angle))), int(np.floor(x + r * np.cos(angle)))
            if 0 <= i < h and 0 <= j < w:
                l[i, j] += 0.847
    np.clip(l, -5, 5, out=l)
    return l
