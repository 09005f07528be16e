"""One vote a scan and cell: the cells that are crossed first, then those that stop a ray; bounds after each vote."""
def vers_logodds(p):
    p = np.asarray(p, dtype=float)
    return np.log(p) - np.log1p(-p)


def vers_proba(l):
    return 0.5 * (1 + np.tanh(np.asarray(l, dtype=float) / 2))


def integrer_scan(l, pose, scan, portee_max):
    grille = np.array(l, dtype=float)
    x, y, cap = pose
    traversees, murs = set(), set()
    for k, z in enumerate(scan):
        a = cap + 2 * np.pi * k / len(scan)
        u = np.array([np.cos(a), np.sin(a)])
        for d in np.arange(0, min(z, portee_max), 0.1):
            i, j = np.floor([y + d * u[1], x + d * u[0]]).astype(int)
            traversees.add((i, j))
        if z < portee_max:
            i, j = np.floor([y + (z + 1e-3) * u[1], x + (z + 1e-3) * u[0]]).astype(int)
            murs.add((i, j))
    for cases, voix in ((traversees, -0.847), (murs, 0.847)):
        for i, j in cases:
            if 0 <= i < grille.shape[0] and 0 <= j < grille.shape[1]:
                grille[i, j] = max(-5, min(5, grille[i, j] + voix))
    return grille
