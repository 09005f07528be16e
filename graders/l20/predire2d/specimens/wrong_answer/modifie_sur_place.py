"""Right values, but both arguments are overwritten."""


def predire2d(bel, du, dv):
    nouvelle = np.zeros((H, W))
    for y, x in np.argwhere(bel > 0):
        for p, ex, ey in ((0.8, du, dv), (0.1, du + dv, dv + du), (0.1, du - dv, dv - du)):
            a, b = y + ey, x + ex
            if (du, dv) == (0, 0) or not (0 <= a < H and 0 <= b < W and libres[a, b]):
                a, b = y, x
            nouvelle[a, b] += p * bel[y, x]
    bel[:] = nouvelle
    return bel


def corriger2d(bel, scan_obs, sigma=0.5):
    for y, x in np.argwhere(libres):
        bel[y, x] *= np.exp(-np.sum((scan_obs - lidar((x + 0.5, y + 0.5, 0), 4)) ** 2) / (2 * sigma**2))
    bel /= bel.sum()
    return bel
