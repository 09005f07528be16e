def gain(v, r):
    return v / (v + r)


def fusionner(mesures, variances):
    poids = 1 / variances
    if len(mesures) = 1:
        return mesures[0], variances[0]
    return np.sum(poids * mesures) / np.sum(poids), 1 / np.sum(poids)


def enchainer(m, v, mesures, variances):
    return []
