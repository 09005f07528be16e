"""Crossings of the lines, sorted; middles of the pieces."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(l, pose, scan, portee_max):
    x, y, theta = pose
    sortie = np.array(l, dtype=float)
    H_, W_ = sortie.shape
    for k, z in enumerate(scan):
        a = theta + k * (2 * np.pi / len(scan))
        c, s = np.cos(a), np.sin(a)
        fin = min(z, portee_max)
        t = [0.0, fin]
        if abs(c) > 1e-12:
            t += [(X - x) / c for X in range(-20, 60) if 0 < (X - x) / c < fin]
        if abs(s) > 1e-12:
            t += [(Y - y) / s for Y in range(-20, 60) if 0 < (Y - y) / s < fin]
        t.sort()
        r = z + 1e-9
        but = (int(np.floor(y + r * s)), int(np.floor(x + r * c))) if z < portee_max else None
        for debut, suite in zip(t, t[1:]):
            m = (debut + suite) / 2
            case = (int(np.floor(y + m * s)), int(np.floor(x + m * c)))
            if suite - debut > 1e-9 and case != but and 0 <= case[0] < H_ and 0 <= case[1] < W_:
                sortie[case] += np.log(0.3 / 0.7)
        if but is not None and 0 <= but[0] < H_ and 0 <= but[1] < W_:
            sortie[but] += np.log(0.7 / 0.3)
    return np.maximum(-5, np.minimum(5, sortie))
