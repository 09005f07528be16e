def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    distances = [np.linalg.norm(signature(scans[j]) - reference) for j in range(i - 9)]
    return sorted((j for j, d in enumerate(distances) if d <= seuil), key=lambda j: distances[j])
