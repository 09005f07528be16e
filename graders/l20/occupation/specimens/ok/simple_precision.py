"""A grid in single precision; the robot's own cell is always free."""
def vers_logodds(p):
    return np.log(p / (1 - p))


def vers_proba(l):
    return 1 / (1 + np.exp(-l))


def integrer_scan(l, pose, scan, portee_max):
    g = np.array(l, dtype=np.float32)
    x, y, theta = pose
    for k, z in enumerate(scan):
        a = theta + 2 * np.pi * k / len(scan)
        vues = {(int(np.floor(y)), int(np.floor(x)))}
        for d in np.arange(0.01, min(z, portee_max), 0.04):
            vues.add((int(np.floor(y + d * np.sin(a))), int(np.floor(x + d * np.cos(a)))))
        m = (int(np.floor(y + (z + 0.01) * np.sin(a))), int(np.floor(x + (z + 0.01) * np.cos(a))))
        vues.discard(m)
        for c in vues:
            if 0 <= c[0] < H and 0 <= c[1] < W:
                g[c] -= np.float32(0.847)
        if z < portee_max and 0 <= m[0] < H and 0 <= m[1] < W:
            g[m] += np.float32(0.847)
        elif z >= portee_max and 0 <= m[0] < H and 0 <= m[1] < W:
            d = portee_max - 0.001
            if m == (int(np.floor(y + d * np.sin(a))), int(np.floor(x + d * np.cos(a)))):
                g[m] -= np.float32(0.847)
    return np.clip(g, -5, 5)
