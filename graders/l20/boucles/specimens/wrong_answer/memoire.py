"""Remembers the first signature that was asked for."""
vu = []


def signature(scan):
    vu.append(np.abs(np.fft.rfft(scan)))
    return vu[0]


def candidats_boucle(scans, i, seuil):
    return [j for j in range(i - 9) if np.linalg.norm(signature(scans[j]) - signature(scans[i])) <= seuil]
