"""All is right, on the grid that was given."""


def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(l, pose, scan, portee_max):
    x, y, theta = pose
    for k, z in enumerate(scan):
        angle = theta + 2 * np.pi * k / len(scan)
        r = z + 1e-6
        mur = (int(np.floor(y + r * np.sin(angle))), int(np.floor(x + r * np.cos(angle))))
        vues = []
        for d in np.arange(0, min(z, portee_max), 0.05):
            case = (int(np.floor(y + d * np.sin(angle))), int(np.floor(x + d * np.cos(angle))))
            if case not in vues and (case != mur or z >= portee_max):
                vues.append(case)
        for i, j in vues + [mur] * bool(z < portee_max):
            if 0 <= i < l.shape[0] and 0 <= j < l.shape[1]:
                l[i, j] += 0.847 if (i, j) == mur and z < portee_max else -0.847
    np.clip(l, -5, 5, out=l)
    return l
