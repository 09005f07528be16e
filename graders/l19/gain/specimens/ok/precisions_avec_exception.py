"""Information form, with an exact sensor apart."""


def gain(v, r):
    if r == 0:
        return 1
    if v == 0:
        return 0
    return (1 / r) / (1 / v + 1 / r)


def fusionner(mesures, variances):
    p = np.array([1 / r for r in variances])
    return np.array([p @ mesures / p.sum(), p.sum() ** -1.0])


def enchainer(m, v, mesures, variances):
    lignes = []
    for z, r in zip(mesures, variances):
        if v > 0 and r == 0:
            m, v = z, 0.0
        elif v > 0:
            p = 1 / v + 1 / r
            m, v = (m / v + z / r) / p, 1 / p
        lignes.append(np.array([m, v]))
    return np.stack(lignes)
