"""A class that holds the places; the spectrum of the logarithm of the distances."""


class Memoire:
    def __init__(self, scans):
        self.signatures = [signature(scan) for scan in scans]

    def ecart(self, i, j):
        return float(np.hypot.reduce(self.signatures[i] - self.signatures[j]))

    def proches(self, i, seuil):
        for j in range(len(self.signatures)):
            if j <= i - 10 and self.ecart(i, j) <= seuil:
                yield j


def signature(scan):
    return np.absolute(np.fft.rfft(np.log1p(scan)))


def candidats_boucle(scans, i, seuil):
    return list(Memoire(scans).proches(i, seuil))
