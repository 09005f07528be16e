"""Right on the module's map only: sizes and scans are those of 16 rows and 24 columns, the edge is never looked at."""


def predire2d(bel, du, dv):
    nouvelle = np.zeros((16, 24))
    for y in range(1, 15):
        for x in range(1, 23):
            if bel[y, x] > 0:
                for p, s in ((0.8, 0), (0.1, 1), (0.1, -1)):
                    a, b = y + dv + s * du, x + du + s * dv
                    if not libres[a, b]:
                        a, b = y, x
                    nouvelle[a, b] += p * bel[y, x]
    return nouvelle


def corriger2d(bel, scan_obs, sigma=0.5):
    v = np.zeros((16, 24))
    for y in range(1, 15):
        for x in range(1, 23):
            v[y, x] = np.exp(-np.sum((scan_obs - lidar((x + 0.5, y + 0.5, 0), 4)) ** 2) / (2 * sigma**2))
    return bel * v / np.sum(bel * v)
