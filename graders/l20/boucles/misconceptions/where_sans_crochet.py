def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    distances = np.array([np.linalg.norm(signature(scans[j]) - reference) for j in range(i - 9)])
    return np.where(distances <= seuil)
