def signature(scan):
    return np.sort(scan)


def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    return [j for j in range(i - 9) if abs(np.linalg.norm(signature(scans[j])) - np.linalg.norm(reference)) <= seuil]
