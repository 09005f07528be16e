def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    return [j for j, scan in enumerate(scans[: i - 9]) if np.linalg.norm(signature(scan) - reference) <= seuil]
