"""The outline that the rays draw: lengths of its sides, then areas of its triangles, both sorted."""


def signature(scan):
    angles = 2 * np.pi * np.arange(len(scan)) / len(scan)
    points = scan * np.exp(1j * angles)
    suivants = np.roll(points, -1)
    cotes = np.abs(suivants - points)
    aires = (np.conj(points) * suivants).imag / 2
    return np.hstack([np.sort(cotes), np.sort(aires)])


def candidats_boucle(scans, i, seuil):
    resultat = np.zeros(0, dtype=int)
    for j in range(i - 9):
        if np.sum(np.abs(signature(scans[i]) - signature(scans[j]))) <= seuil:
            resultat = np.append(resultat, j)
    return resultat
