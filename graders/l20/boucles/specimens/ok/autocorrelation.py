"""The products of the scan with its 36 shifts, by loops and lists."""


def signature(scan):
    n = len(scan)
    return [sum(float(scan[k]) * float(scan[(k + d) % n]) for k in range(n)) / n for d in range(n // 2 + 1)]


def candidats_boucle(scans, i, seuil):
    if i < 10:
        return []
    modele = np.array(signature(scans[i]))
    ecarts = {j: float(np.mean(np.abs(np.array(signature(scans[j])) - modele))) for j in range(i - 9)}
    return sorted(j for j, ecart in ecarts.items() if ecart <= seuil)
