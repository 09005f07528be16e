def signature(scan):
    return np.zeros(5)


def candidats_boucle(scans, i, seuil):
    return np.array([])
