"""Slices of a padded belief: nothing is looped over but the three outcomes."""
BORD = 2
CARTE = np.zeros((H + 2 * BORD, W + 2 * BORD))
CARTE[BORD:-BORD, BORD:-BORD] = libres


def vue(tableau, dy, dx):
    return tableau[BORD + dy: BORD + dy + H, BORD + dx: BORD + dx + W]


def predire2d(bel, du, dv):
    large = np.zeros_like(CARTE)
    large[BORD:-BORD, BORD:-BORD] = bel
    sortie = np.zeros((H, W))
    for p, k in zip((0.1, 0.8, 0.1), (-1, 0, 1)):
        dy, dx = dv + k * du, du + k * dv
        sortie += p * vue(large, -dy, -dx) * libres
        sortie += p * bel * (1 - vue(CARTE, dy, dx))
    return sortie


ys, xs = np.indices((H, W))
VUES = lidar_lot(np.column_stack([xs.ravel() + 0.5, ys.ravel() + 0.5, np.zeros(H * W)]), 4).reshape(H, W, 4)


def corriger2d(bel, scan_obs, sigma=0.5):
    v = np.exp(np.sum((VUES - scan_obs) ** 2, axis=-1) / (-2.0 * sigma * sigma))
    v[~libres] = 0
    p = bel * v
    return p / np.sum(p)
