def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    return [j for j in range(i) if np.linalg.norm(signature(scans[j]) - reference) <= seuil]
