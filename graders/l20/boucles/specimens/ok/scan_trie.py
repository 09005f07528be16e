"""Sorted distances: an order that no turn changes; the greatest gap; a plain while loop."""


def signature(scan):
    return np.sort(scan)


def candidats_boucle(scans, i, seuil):
    trouves, j = [], 0
    ici = signature(scans[i])
    while j + 10 <= i:
        if np.max(np.abs(signature(scans[j]) - ici)) <= seuil:
            trouves.append(j)
        j += 1
    return trouves
