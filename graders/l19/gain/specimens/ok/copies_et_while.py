def gain(*variances):
    return variances[0] / sum(variances)


def fusionner(mesures, variances):
    z, r = mesures.copy(), variances.copy()
    z /= r
    r **= -1
    return z.sum() / r.sum(), r.sum() ** -1


def enchainer(m, v, mesures, variances):
    file = list(zip(mesures, variances))[::-1]
    vues = np.array([[], []])
    while file:
        z, r = file.pop()
        K = gain(v, r)
        m, v = m - K * m + K * z, v - K * v
        vues = np.hstack([vues, [[m], [v]]])
    return vues.T
