def gain(v, r):
    print(v / (v + r))


def fusionner(mesures, variances):
    poids = 1 / variances
    print(np.sum(poids * mesures) / np.sum(poids))


def enchainer(m, v, mesures, variances):
    for z, r in zip(mesures, variances):
        m = m + v / (v + r) * (z - m)
        print(m)
