"""Candidates by the best of the 36 alignments; the signature starts from the longest ray."""


def signature(scan):
    return np.roll(scan, -int(np.argmax(scan)))


def candidats_boucle(scans, i, seuil):
    def ecart(a, b):
        return min(np.linalg.norm(np.roll(a, k) - b) for k in range(len(a)))

    return [j for j in range(max(i - 9, 0)) if ecart(scans[j], scans[i]) <= seuil]
