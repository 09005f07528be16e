def gain(v, r):
    return v / (v + r)


def fusionner(mesures, variances):
    poids = 1 / variances
    moyenne = np.sum(poids * mesures) / np.sum(poids)
    variance = 1 / np.sum(poids)
    return moyenne, variance


def enchainer(m, v, mesures, variances):
    croyances = []
    for z, r in zip(mesures, variances, strict=True):
        K = v / (v + r)
        m = m + K * (z - m)
        v = (1 - K) * v
        croyances.append([m, v])
    return np.array(croyances)
