def predire2d(bel, du, dv):
    return bel[H + du, W + dv] * bel


def corriger2d(bel, scan_obs, sigma):
    return bel / zero
