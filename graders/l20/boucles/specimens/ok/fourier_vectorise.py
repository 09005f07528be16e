from __future__ import annotations

from scipy.spatial.distance import cdist

import numpy


def signature(scan: numpy.ndarray) -> numpy.ndarray:
    return numpy.abs(numpy.fft.fft(scan))[:19]


def candidats_boucle(scans, i, seuil):
    spectres = np.apply_along_axis(signature, 1, np.asarray(scans))
    distances = cdist(spectres[[i]], spectres)[0]
    indices = np.arange(len(scans))
    return np.flatnonzero((distances <= seuil) & (indices <= i - 10))


if __name__ == "__main__":
    raise SystemExit("jamais ici")
