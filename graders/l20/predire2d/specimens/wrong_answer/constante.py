"""The same belief whatever is given."""


def predire2d(bel, du, dv):
    return libres / libres.sum()


def corriger2d(bel, scan_obs, sigma=0.5):
    return libres / libres.sum()
