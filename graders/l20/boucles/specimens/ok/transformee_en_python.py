"""The definition of the transform, term by term: slow, and honest."""
import cmath


def signature(scan):
    n = len(scan)
    return [abs(sum(z * cmath.exp(-2j * cmath.pi * f * k / n) for k, z in enumerate(scan))) for f in range(n)]


def candidats_boucle(scans, i, seuil):
    return [j for j in range(0, i - 9)
            if max(abs(a - b) for a, b in zip(signature(scans[j]), signature(scans[i]))) <= seuil]
