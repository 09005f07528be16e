"""logit and expit; a dictionary of cells, written into the grid at the end; try instead of bounds."""
from scipy.special import expit, logit

vers_logodds = logit
AVIS = float(logit(0.7))


def vers_proba(x):
    return expit(x)


def integrer_scan(l, pose, scan, portee_max):
    cases = {(i, j): v for i, ligne in enumerate(l.tolist()) for j, v in enumerate(ligne)}
    x, y, theta = pose
    for k, z in enumerate(scan):
        a = theta + 2 * np.pi * k / len(scan)
        dx, dy = np.cos(a), np.sin(a)
        longueur = z if z < portee_max else portee_max
        vues = []
        for d in np.arange(0, longueur, 0.025):
            c = (int((y + d * dy) // 1), int((x + d * dx) // 1))
            if not vues or vues[-1] != c:
                vues.append(c)
        fin = (int((y + (z + 1e-6) * dy) // 1), int((x + (z + 1e-6) * dx) // 1))
        if z < portee_max:
            if vues[-1] == fin:
                vues.pop()
            if fin in cases:
                cases[fin] += AVIS
        for c in vues:
            if c in cases:
                cases[c] -= AVIS
    sortie = np.empty(l.shape)
    for (i, j), v in cases.items():
        sortie[i, j] = min(max(v, -5), 5)
    return sortie
