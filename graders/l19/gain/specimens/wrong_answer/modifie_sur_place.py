"""Right values, but both arrays are changed on the way."""


def gain(v, r):
    return v / (v + r)


def fusionner(mesures, variances):
    mesures /= variances
    variances **= -1
    return mesures.sum() / variances.sum(), 1 / variances.sum()


def enchainer(m, v, mesures, variances):
    for i in range(len(mesures)):
        K = gain(v, variances[i])
        m, v = m + K * (mesures[i] - m), (1 - K) * v
        mesures[i], variances[i] = m, v
    return np.column_stack([mesures, variances])
