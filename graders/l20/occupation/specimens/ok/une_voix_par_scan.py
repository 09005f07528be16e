"""One vote a cell and a scan, stopping wins; sets; the robot's own cell is left alone; nested lists come back."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(l, pose, scan, portee_max):
    x, y, theta = map(float, pose)
    libres_vues, murs_vus = set(), set()
    for k, z in enumerate(scan):
        a = theta + 2 * np.pi * k / len(scan)
        d = 0.0
        while d < min(z, portee_max):
            libres_vues.add((int(np.floor(y + d * np.sin(a))), int(np.floor(x + d * np.cos(a)))))
            d += 0.02
        if z < portee_max:
            d = z + 1e-4
            murs_vus.add((int(np.floor(y + d * np.sin(a))), int(np.floor(x + d * np.cos(a)))))
    libres_vues -= murs_vus | {(int(y), int(x))}
    resultat = [list(map(float, ligne)) for ligne in l]
    for vues, delta in ((libres_vues, -0.847), (murs_vus, 0.847)):
        for i, j in vues:
            if 0 <= i < len(resultat) and 0 <= j < len(resultat[0]):
                resultat[i][j] = max(-5.0, min(5.0, resultat[i][j] + delta))
    return resultat
