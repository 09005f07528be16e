"""Shifts of the whole table along one axis, then the other; what hits a wall is put back."""


def decaler(t, n, axe):
    if n == 0:
        return t.copy()
    r = np.zeros_like(t)
    t, r = np.moveaxis(t, axe, 0), np.moveaxis(r, axe, 0)
    if abs(n) < len(t):
        if n > 0:
            r[n:] = t[:-n]
        else:
            r[:n] = t[-n:]
    return np.moveaxis(r, 0, axe)


def issue(bel, dx, dy):
    libre_la_bas = decaler(decaler(libres, -dy, 0), -dx, 1)
    passe = np.where(libre_la_bas, bel, 0.0)
    return decaler(decaler(passe, dy, 0), dx, 1) + (bel - passe)


def predire2d(bel, du, dv):
    droit = issue(bel, du, dv)
    if du == dv == 0:
        return droit
    return np.average([droit, issue(bel, du + dv, dv + du), issue(bel, du - dv, dv - du)], axis=0, weights=[8, 1, 1])


def corriger2d(bel, scan_obs, sigma=0.5):
    ou = np.argwhere(bel)
    z = np.array([lidar((x + 0.5, y + 0.5, 0.0), 4) for y, x in ou])
    chacun = np.exp(-((z - scan_obs) ** 2) / (2 * sigma**2)).prod(axis=1) * bel[tuple(ou.T)]
    rendu = np.zeros((H, W), dtype=np.float64)
    rendu[tuple(ou.T)] = chacun / chacun.sum()
    return rendu
