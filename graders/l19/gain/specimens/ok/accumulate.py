from itertools import accumulate, islice


def gain(v, r):
    return 1 - r / (v + r)


def corrige(croyance, mesure):
    (m, v), (z, r) = croyance, mesure
    K = gain(v, r)
    return m + K * (z - m), (1 - K) * v


def enchainer(m, v, mesures, variances):
    return np.array(list(islice(accumulate(zip(mesures, variances), corrige, initial=(m, v)), 1, None)))


def fusionner(mesures, variances):
    *_, derniere = accumulate(zip(mesures, variances), corrige)
    return derniere
