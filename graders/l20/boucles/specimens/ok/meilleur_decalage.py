"""Candidates by the best of the 36 alignments; the signature is the smallest of the 36 rotations."""


def signature(scan):
    return np.array(min(tuple(np.roll(scan, k)) for k in range(len(scan))))


def candidats_boucle(scans, i, seuil):
    def ecart(a, b):
        return min(np.linalg.norm(np.roll(a, k) - b) for k in range(len(a)))

    return [j for j in range(max(i - 9, 0)) if ecart(scans[j], scans[i]) <= seuil]
