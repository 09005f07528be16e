def candidats_boucle(scans, i, seuil):
    return [j for j in range(i - 9) if np.linalg.norm(scans[j] - scans[i]) <= seuil]
