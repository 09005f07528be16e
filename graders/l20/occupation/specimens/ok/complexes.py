"""Points and headings are complex numbers; a Counter of votes."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


import cmath
from collections import Counter


def case_de(z):
    return (int(np.floor(z.imag)), int(np.floor(z.real)))


def integrer_scan(l, pose, scan, portee_max):
    centre, n = complex(pose[0], pose[1]), len(scan)
    votes = Counter()
    for k, z in enumerate(scan):
        u = cmath.exp(1j * (pose[2] + 2 * cmath.pi * k / n))
        touche = z < portee_max
        mur = case_de(centre + (z + 1e-5) * u)
        libres_du_rayon = {case_de(centre + d * u) for d in np.arange(0.0, min(z, portee_max), 0.03)}
        for case in libres_du_rayon - ({mur} if touche else set()):
            votes[case] -= 1
        if touche:
            votes[mur] += 1
    nouvelle = l + 0.0
    for (i, j), v in votes.items():
        if 0 <= i < l.shape[0] and 0 <= j < l.shape[1]:
            nouvelle[i, j] += v * 0.847
    return np.clip(nouvelle, -5, 5)
