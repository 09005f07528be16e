"""Bresenham's segment from cell to cell: not the cells that the ray goes through."""


def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def segment(i0, j0, i1, j1):
    n = max(abs(i1 - i0), abs(j1 - j0), 1)
    return [(round(i0 + (i1 - i0) * t / n), round(j0 + (j1 - j0) * t / n)) for t in range(n + 1)]


def integrer_scan(l, pose, scan, portee_max):
    l = l.copy()
    x, y, theta = pose
    for k, z in enumerate(scan):
        a = theta + 2 * np.pi * k / len(scan)
        r = min(z + 1e-6, portee_max)
        i, j = int(np.floor(y + r * np.sin(a))), int(np.floor(x + r * np.cos(a)))
        cases = segment(int(y), int(x), i, j)
        for c in cases[:-1] if z < portee_max else cases:
            if 0 <= c[0] < l.shape[0] and 0 <= c[1] < l.shape[1]:
                l[c] -= 0.847
        if z < portee_max and 0 <= i < l.shape[0] and 0 <= j < l.shape[1]:
            l[i, j] += 0.847
    return np.clip(l, -5, 5)
