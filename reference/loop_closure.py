"""Loop closure candidates: scans that were taken at one place, whatever the heading.

A scan is an array (n,) of distances read by beams spread evenly over a whole turn; a change of heading by a multiple of
2 pi / n shifts it circularly. A signature is a function of the scan that such a shift leaves alone.

Sources: Oppenheim and Schafer, "Discrete-Time Signal Processing" (2010), section 8.6.2 (a circular shift changes only
the phases of the discrete Fourier transform); Röfer, "Using Histogram Correlation to Create Consistent Laser Scan
Maps" (2002), for histograms of scans.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference.errors import InvalidArgumentError

Floats = NDArray[np.float64]

MIN_GAP = 10


class LoopClosureError(InvalidArgumentError):
    """Input in which no loop can be looked for; `argument` names it."""


@dataclass(frozen=True)
class LoopCandidates:
    """Scans of the past that look like one scan: their `indices` (k,), increasing, and `distances` (k,) to it."""

    indices: NDArray[np.int64]
    distances: Floats


def fourier_signature(scan: ArrayLike) -> Floats:
    """The amplitudes (n // 2 + 1,) of the scan's discrete Fourier transform, in the unit of the distances.

    With Z_f = sum_k z_k exp(-2 i pi f k / n), shifting z by s beams multiplies Z_f by exp(2 i pi f s / n), of modulus
    one: |Z_f| does not change. Raises LoopClosureError.
    """
    return np.asarray(np.abs(np.fft.rfft(_check_scan(scan))), dtype=np.float64)


def histogram_signature(scan: ArrayLike, max_range: float, bins: int) -> Floats:
    """How many of the n distances fall in each of `bins` equal boxes of [0, max_range], (bins,).

    The count forgets the order of the beams, hence the heading. Raises LoopClosureError.
    """
    distances = _check_scan(scan)
    if not 0.0 < max_range < np.inf:
        raise LoopClosureError("max_range", f"{max_range} is not a positive length")
    if bins < 1:
        raise LoopClosureError("bins", f"{bins} boxes hold nothing")
    if np.any((distances < 0.0) | (distances > max_range)):
        raise LoopClosureError("scan", f"has distances outside [0, {max_range}]")
    return np.histogram(distances, bins=bins, range=(0.0, max_range))[0].astype(np.float64)


def loop_candidates(signatures: ArrayLike, i: int, threshold: float, *, min_gap: int = MIN_GAP) -> LoopCandidates:
    """The scans j <= i - min_gap whose signature is within `threshold` of that of i, in Euclidean distance.

    `signatures` is an array (m, k), one signature a row. Raises LoopClosureError.
    """
    rows = np.asarray(signatures, dtype=np.float64)
    if rows.ndim != 2 or not np.all(np.isfinite(rows)):
        raise LoopClosureError("signatures", f"of shape {rows.shape} is not an array (m, k) of finite numbers")
    if not 0 <= i < len(rows):
        raise LoopClosureError("i", f"{i} is not one of the {len(rows)} scans")
    if not threshold >= 0.0:
        raise LoopClosureError("threshold", f"{threshold} is not a distance")
    if min_gap < 1:
        raise LoopClosureError("min_gap", f"{min_gap} does not keep a scan from itself")
    past = max(0, i - min_gap + 1)
    distances = np.linalg.norm(rows[:past] - rows[i], axis=1)
    indices = np.flatnonzero(distances <= threshold)
    return LoopCandidates(indices, distances[indices])


def _check_scan(scan: ArrayLike) -> Floats:
    distances = np.asarray(scan, dtype=np.float64)
    if distances.ndim != 1 or distances.size == 0 or not np.all(np.isfinite(distances)):
        raise LoopClosureError("scan", f"of shape {distances.shape} is not an array (n,) of finite distances")
    return distances
