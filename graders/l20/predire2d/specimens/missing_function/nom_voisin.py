def predire(bel, du, dv):
    return bel


def corriger2d(bel, scan_obs, sigma=0.5):
    return bel
