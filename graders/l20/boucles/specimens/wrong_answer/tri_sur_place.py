"""Right values, but the scans that were given are sorted in place."""


def signature(scan):
    scan.sort()
    return scan


def candidats_boucle(scans, i, seuil):
    a = signature(scans[i].copy())
    return [j for j in range(i - 9) if np.linalg.norm(signature(scans[j].copy()) - a) <= seuil]
