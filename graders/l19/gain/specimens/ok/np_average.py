def gain(v, r):
    return np.divide(v, np.add(v, r))


def fusionner(mesures, variances):
    moyenne, somme = np.average(mesures, weights=np.reciprocal(variances), returned=True)
    return moyenne, 1 / somme


def enchainer(m, v, mesures, variances):
    sortie = np.empty((len(mesures), 2))
    for ligne, z, r in zip(sortie, mesures, variances):
        K = gain(v, r)
        ligne[:] = m, v = m + K * (z - m), (1 - K) * v
    return sortie
