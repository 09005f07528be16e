"""No loop: cumulated precisions, and what follows an exact reading filled in."""


def gain(v, r):
    return 1 / (1 + r / v) if v else 0.0


def fusionner(mesures, variances):
    return np.dot(mesures, 1 / variances) / (1 / variances).sum(), 1 / (1 / variances).sum()


def enchainer(m, v, mesures, variances):
    vu = variances > 0
    p = np.cumsum(np.concatenate([[1 / v], np.where(vu, 1 / np.where(vu, variances, 1), 0)]))[1:]
    s = np.cumsum(np.concatenate([[m / v], np.where(vu, mesures / np.where(vu, variances, 1), 0)]))[1:]
    table = np.column_stack([s / p, 1 / p])
    if not vu.all():
        premier = int(np.argmin(vu))
        table[premier:] = mesures[premier], 0
    return table
