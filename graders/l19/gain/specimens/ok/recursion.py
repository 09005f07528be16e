def gain(v, r):
    return v * (v + r) ** -1


def fusionner(mesures, variances):
    if len(mesures) == 1:
        return mesures[0], variances[0]
    m, v = fusionner(mesures[:-1], variances[:-1])
    K = gain(v, variances[-1])
    return m + K * (mesures[-1] - m), (1 - K) * v


def enchainer(m, v, mesures, variances):
    if len(mesures) == 0:
        return []
    K = gain(v, variances[0])
    m, v = m + K * (mesures[0] - m), K * variances[0]
    return [[m, v], *enchainer(m, v, mesures[1:], variances[1:])]
