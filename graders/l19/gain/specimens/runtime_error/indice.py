def gain(v, r):
    return v / (v + s)


def fusionner(mesures, variances):
    total = 0
    for i in range(len(mesures) + 1):
        total += mesures[i] / variances[i]
    return total, 1


def enchainer(m, v, mesures, variances):
    return [gain(m, v)] * len(mesures)
