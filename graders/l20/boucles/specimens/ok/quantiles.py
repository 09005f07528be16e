"""Quantiles, and how often the distance crosses each of them round the circle."""


def signature(scan):
    quantiles = np.quantile(scan, np.linspace(0, 1, 13))
    opposes = np.sort(scan[:18] + scan[18:])
    return np.concatenate((quantiles, opposes))


def candidats_boucle(scans, i, seuil):
    reference = signature(scans[i])
    oui = []
    for j in reversed(range(i - 9)):
        if np.linalg.norm(reference - signature(scans[j])) <= seuil:
            oui.insert(0, j)
    return oui
