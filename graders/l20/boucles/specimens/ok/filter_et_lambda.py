signature = lambda scan: np.abs(np.fft.fft(scan, norm="ortho"))
ecart = lambda a, b: np.sqrt(((a - b) ** 2).sum())
candidats_boucle = lambda scans, i, seuil: tuple(
    filter(lambda j: ecart(signature(scans[i]), signature(scans[j])) <= seuil, range(0, i - 10 + 1)))
