def signature(scan):
    return np.sort(scan)


def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    candidats = []
    for j in range(i - 9):
        distance = np.linalg.norm(signature(scans[j]) - reference)
        if distance <= seuil:
            candidats.append(j)
    return candidats
