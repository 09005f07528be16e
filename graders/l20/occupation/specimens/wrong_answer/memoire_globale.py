"""A map of the program's own, which every call goes on with."""


def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


carte = np.zeros((H, W))


def integrer_scan(l, pose, scan, portee_max):
    x, y, theta = pose
    for k, z in enumerate(scan):
        angle = theta + 2 * np.pi * k / len(scan)
        for d in np.arange(0, min(z, portee_max), 1.0):
            i, j = int(y + d * np.sin(angle)), int(x + d * np.cos(angle))
            if 0 <= i < H and 0 <= j < W:
                carte[i, j] -= 0.847
    return np.clip(carte, -5, 5)
