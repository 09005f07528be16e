def signature(scan):
    return np.sort(scan)


def candidats_boucles(scans, i, seuil):
    return []
