"""Generators and itertools; a padded grid instead of looking at the edges."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


from itertools import takewhile, count, groupby


def le_long(x, y, a):
    for d in count(0, 0.02):
        yield d, (int(np.floor(y + d * np.sin(a))), int(np.floor(x + d * np.cos(a))))


def integrer_scan(l, pose, scan, portee_max):
    marge = 25
    g = np.pad(l, marge)
    x, y, theta = pose
    for k, z in enumerate(scan):
        a = theta + np.pi * 2 * k / len(scan)
        visite = takewhile(lambda p: p[0] < min(z, portee_max), le_long(x, y, a))
        r = z + 1e-6
        mur = (int(np.floor(y + r * np.sin(a))), int(np.floor(x + r * np.cos(a))))
        for (i, j), _ in groupby(case for _, case in visite):
            if z >= portee_max or (i, j) != mur:
                g[i + marge, j + marge] -= 0.8473
        if z < portee_max:
            g[mur[0] + marge, mur[1] + marge] += 0.8473
    return np.clip(g[marge:-marge, marge:-marge], -5, 5)
