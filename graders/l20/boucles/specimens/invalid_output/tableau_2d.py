def signature(scan):
    return np.abs(np.fft.rfft(scan)).reshape(1, -1)


def candidats_boucle(scans, i, seuil):
    return [j for j in range(i - 9) if np.linalg.norm(signature(scans[j]) - signature(scans[i])) <= seuil]
