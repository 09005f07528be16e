def predire2d(bel, du, dv):
    return np.zeros((H, W)


def corriger2d(bel, scan_obs, sigma=0.5):
    return bel
