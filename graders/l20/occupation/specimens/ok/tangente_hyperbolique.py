"""Other formulas for the odds; the borders of every ray found with np.union1d; tuples come back."""
def vers_logodds(p):
    return 2 * np.arctanh(2 * np.asarray(p) - 1)


def vers_proba(l):
    return (1 + np.tanh(np.asarray(l) / 2)) / 2


def coupures(depart, pente, longueur):
    if abs(pente) < 1e-12:
        return np.array([])
    bout = depart + pente * longueur
    entiers = np.arange(np.floor(min(depart, bout)) - 1, np.ceil(max(depart, bout)) + 2)
    t = (entiers - depart) / pente
    return t[(t > 0) & (t < longueur)]


def integrer_scan(l, pose, scan, portee_max):
    x, y, theta = pose
    g = l.copy()
    for k, z in enumerate(scan):
        a = theta + 2 * np.pi * k / len(scan)
        L = min(z, portee_max)
        t = np.concatenate([[0.0], np.union1d(coupures(x, np.cos(a), L), coupures(y, np.sin(a), L)), [L]])
        m = (t[1:] + t[:-1])[np.diff(t) > 1e-9] / 2
        i, j = np.floor(y + m * np.sin(a)).astype(int), np.floor(x + m * np.cos(a)).astype(int)
        bi, bj = int(np.floor(y + (z + 1e-8) * np.sin(a))), int(np.floor(x + (z + 1e-8) * np.cos(a)))
        garde = (i >= 0) & (i < g.shape[0]) & (j >= 0) & (j < g.shape[1])
        if z < portee_max:
            garde &= (i != bi) | (j != bj)
            if 0 <= bi < g.shape[0] and 0 <= bj < g.shape[1]:
                g[bi, bj] += 0.8472978603872034
        g[i[garde], j[garde]] -= 0.8472978603872034
    return tuple(map(tuple, np.clip(g, -5, 5).tolist()))
