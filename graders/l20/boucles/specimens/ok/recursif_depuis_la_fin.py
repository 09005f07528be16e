"""Candidates by recursion, the last one first and put back in order; power spectrum."""
from functools import lru_cache


def signature(scan):
    z = np.fft.fft(np.asarray(scan, dtype=float))
    return (z * z.conjugate()).real[:19] / len(scan)


def candidats_boucle(scans, i, seuil):
    @lru_cache(maxsize=None)
    def connue(j):
        return signature(scans[j])

    def jusqu_a(j):
        if j < 0:
            return []
        avant = jusqu_a(j - 1)
        return [*avant, j] if np.linalg.norm(connue(j) - connue(i), 1) <= seuil else avant

    return jusqu_a(i - 10)
