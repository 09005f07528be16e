"""A generator of arrivals for each cell; np.ndenumerate; sums by hand."""


def arrivees(y, x, du, dv):
    for p, cote in ((0.8, 0), (0.1, -1), (0.1, 1)):
        ny, nx = y + dv + cote * du, x + du + cote * dv
        dedans = 0 <= ny < H and 0 <= nx < W
        yield (p, ny, nx) if dedans and libres[ny, nx] else (p, y, x)


def predire2d(bel, du, dv):
    resultat = np.zeros_like(bel)
    for (y, x), b in np.ndenumerate(bel):
        if b > 0:
            for p, ny, nx in arrivees(y, x, du, dv):
                resultat[ny, nx] += p * b
    return resultat


def corriger2d(bel, scan_obs, sigma=0.5):
    resultat = np.zeros_like(bel)
    for (y, x), b in np.ndenumerate(bel):
        if b > 0:
            vu = lidar((x + 0.5, y + 0.5, 0.0), 4)
            resultat[y, x] = b * np.exp(-((scan_obs - vu) ** 2).sum() / (2 * sigma**2))
    resultat /= resultat.sum()
    return resultat
