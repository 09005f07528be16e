def signature(scan):
    return np.sort(scan)


def candidats_boucle(scans, i, seuil):
    return [j for j in range(i - 9) if np.linalg.norm(signature(scans[j + i]) - signature(scans[i])) <= seuil]
