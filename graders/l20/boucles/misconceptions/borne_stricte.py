def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    return [j for j in range(len(scans)) if j < i - 10 and np.linalg.norm(signature(scans[j]) - reference) <= seuil]
