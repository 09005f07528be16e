"""One number, made of the whole scan: no fixed statistic is shared, but places share this one too."""


def signature(scan):
    return np.array([np.sum(scan**1.7) / 11 + np.sum(np.sqrt(scan))])


def candidats_boucle(scans, i, seuil):
    return [j for j in range(i - 9) if abs(signature(scans[j])[0] - signature(scans[i])[0]) <= seuil]
