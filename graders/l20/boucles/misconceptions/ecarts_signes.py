def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    return [j for j in range(i - 9) if np.sum(signature(scans[j]) - reference) <= seuil]
