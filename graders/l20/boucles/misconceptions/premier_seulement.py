def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    for j in range(i - 9):
        if np.linalg.norm(signature(scans[j]) - reference) <= seuil:
            return [j]
    return []
