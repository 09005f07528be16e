def predire2d(bel, du, dv):
    nouvelle = np.zeros((H, W))
    nouvelle[:] = bel


def corriger2d(bel, scan_obs, sigma=0.5):
    return "la croyance"
