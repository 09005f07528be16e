"""The expected scans are drawn with noise: nearly right, never the same."""


def predire2d(bel, du, dv):
    return bel


def corriger2d(bel, scan_obs, sigma=0.5):
    v = np.zeros((H, W))
    for y, x in np.argwhere(libres):
        v[y, x] = bel[y, x] * np.exp(-np.sum((scan_obs - lidar((x + 0.5, y + 0.5, 0), 4, 0.05)) ** 2) / (2 * sigma**2))
    return v / v.sum()
