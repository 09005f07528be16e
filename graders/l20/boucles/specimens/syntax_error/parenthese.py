def signature(scan):
    return np.abs(np.fft.rfft(scan)


def candidats_boucle(scans, i, seuil):
    return []
