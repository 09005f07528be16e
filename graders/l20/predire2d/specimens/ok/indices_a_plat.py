"""Flat indices and np.bincount; float32 in the likelihood alone would be too coarse, so all is float64."""
LARGE = W + 2
PLAT = np.pad(libres, 1).ravel()
OU = np.flatnonzero(PLAT)


def predire2d(bel, du, dv):
    p = np.pad(bel, 1).ravel()[OU]
    total = np.zeros(PLAT.size)
    for q, pas in ((0.8, dv * LARGE + du), (0.1, (dv + du) * LARGE + du + dv), (0.1, (dv - du) * LARGE + du - dv)):
        cible = np.where(PLAT[OU + pas], OU + pas, OU)
        total += q * np.bincount(cible, weights=p, minlength=PLAT.size)
    return total.reshape(H + 2, LARGE)[1:-1, 1:-1]


def corriger2d(bel, scan_obs, sigma=0.5):
    y, x = np.divmod(OU, LARGE)
    attendus = lidar_lot(np.transpose([x - 0.5, y - 0.5, 0.0 * x]), 4)
    v = np.zeros(PLAT.size)
    v[OU] = np.exp(-np.einsum("nk,nk->n", attendus - scan_obs, attendus - scan_obs) / (2 * sigma**2))
    p = bel * v.reshape(H + 2, LARGE)[1:-1, 1:-1]
    return np.divide(p, p.sum())
