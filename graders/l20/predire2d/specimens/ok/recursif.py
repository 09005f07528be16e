"""predire2d of a doubt is the sum of predire2d of its halves, down to one cell."""


def seule(y, x, p, du, dv):
    t = np.zeros((H, W))
    for q, s in ((8, 0), (1, 1), (1, -1)):
        a, b = y + dv + s * du, x + du + s * dv
        if not (0 <= a < H and 0 <= b < W) or not libres[a, b]:
            a, b = y, x
        t[a, b] += p * q / 10
    return t


def somme(cases, du, dv):
    if not cases:
        return np.zeros((H, W))
    if len(cases) == 1:
        return seule(*cases[0], du, dv)
    moitie = len(cases) // 2
    return somme(cases[:moitie], du, dv) + somme(cases[moitie:], du, dv)


def predire2d(bel, du, dv):
    return somme([(y, x, bel[y, x]) for y, x in np.argwhere(bel != 0)], du, dv)


def corriger2d(bel, scan_obs, sigma=0.5):
    def poids(cases):
        if len(cases) == 1:
            (y, x), = cases
            z = lidar((x + 0.5, y + 0.5, 0.0), 4)
            return {(y, x): bel[y, x] * np.exp(-sum((z - scan_obs) ** 2) / 2 / sigma / sigma)}
        return {**poids(cases[: len(cases) // 2]), **poids(cases[len(cases) // 2:])}

    trouves = poids([tuple(c) for c in np.argwhere(bel != 0)])
    t = np.zeros((H, W))
    for c, p in trouves.items():
        t[c] = p / sum(trouves.values())
    return t
