import statistics


def signature(scan):
    z = [float(x) for x in scan]
    return np.array([[statistics.fmean(z), statistics.pstdev(z), min(z), max(z), statistics.median(z)]]).ravel()


def candidats_boucle(scans, i, seuil):
    proches = []
    for j, scan in enumerate(scans):
        if i - j >= 10 and np.sum((signature(scan) - signature(scans[i])) ** 2) <= seuil:
            proches.append(np.int64(j))
    return proches
