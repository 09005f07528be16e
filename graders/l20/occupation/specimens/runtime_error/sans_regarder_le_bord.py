"""The ray is walked beyond the grid, and indices are written wherever they fall."""


def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(l, pose, scan, portee_max):
    l = l.copy()
    x, y, theta = pose
    for k, z in enumerate(scan):
        angle = theta + 2 * np.pi * k / len(scan)
        vues = []
        for d in np.arange(0, min(z, portee_max), 0.05):
            case = (int(y + d * np.sin(angle)), int(x + d * np.cos(angle)))
            if case not in vues:
                vues.append(case)
                l[case] -= 0.847
        if z < portee_max:
            r = z + 1e-6
            l[int(y + r * np.sin(angle)), int(x + r * np.cos(angle))] += 0.847
    return np.clip(l, -5, 5)
