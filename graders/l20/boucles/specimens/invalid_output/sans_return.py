def signature(scan):
    np.sort(scan)


def candidats_boucle(scans, i, seuil):
    [j for j in range(i - 9)]
