"""Autocorrelation compared by its cosine, said the other way round; complex numbers kept as they come."""


def signature(scan):
    return np.fft.ifft(np.abs(np.fft.fft(scan - scan.mean())) ** 2)


def candidats_boucle(scans, i, seuil):
    candidats = []
    a = signature(scans[i])
    for j in range(i - 9):
        b = signature(scans[j])
        ressemblance = np.vdot(a, b).real / np.linalg.norm(a) / np.linalg.norm(b)
        if ressemblance >= 1 - seuil:
            candidats += [j]
    return np.array(candidats, dtype=int)
