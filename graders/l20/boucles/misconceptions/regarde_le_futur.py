def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    proches = [np.linalg.norm(signature(scan) - reference) <= seuil for scan in scans]
    return [j for j in range(len(scans)) if abs(i - j) >= 10 and proches[j]]
