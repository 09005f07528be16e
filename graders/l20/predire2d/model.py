def dedans(y, x):
    return 0 <= y < H and 0 <= x < W


def libre(y, x):
    return dedans(y, x) and libres[y, x]


def arrivees(du, dv):
    if (du, dv) == (0, 0):
        return [(1.0, 0, 0)]
    return [(0.8, du, dv), (0.1, du + dv, dv + du), (0.1, du - dv, dv - du)]


def predire2d(bel, du, dv):
    nouvelle = np.zeros((H, W))
    for y, x in np.argwhere(bel):
        for p, dx, dy in arrivees(du, dv):
            y2, x2 = y + dy, x + dx
            if not libre(y2, x2):
                y2, x2 = y, x
            nouvelle[y2, x2] += p * bel[y, x]
    return nouvelle


def ressemblance(scan_obs, z, sigma):
    return np.exp(-np.sum((scan_obs - z) ** 2) / (2 * sigma**2))


def corriger2d(bel, scan_obs, sigma=0.5):
    nouvelle = np.zeros((H, W))
    for y, x in np.argwhere(bel):
        z = lidar((x + 0.5, y + 0.5, 0.0), 4)
        nouvelle[y, x] = bel[y, x] * ressemblance(scan_obs, z, sigma)
    return nouvelle / nouvelle.sum()
