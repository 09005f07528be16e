def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    return np.array([np.linalg.norm(signature(scans[j]) - reference) <= seuil for j in range(i - 9)], dtype=bool)
