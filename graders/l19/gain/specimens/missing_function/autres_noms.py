def gain_de_kalman(v, r):
    return v / (v + r)


def fusion(mesures, variances):
    return np.average(mesures, weights=1 / variances), 1 / np.sum(1 / variances)


def chaine(m, v, mesures, variances):
    return []
