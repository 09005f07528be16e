"""The usual descriptors and distances, by which places are chosen: a yardstick of distinctness, never a judge.

Descriptors map scans (m, n) to signatures (m, k); distances map signatures (m, k), (p, k) to (m, p).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from graders.core.contract.values import Floats
from graders.l20 import world

Descriptor = Callable[[Floats], Floats]
Distance = Callable[[Floats, Floats], Floats]


def _spectrum(scans: Floats) -> Floats:
    return np.asarray(np.abs(np.fft.rfft(scans, axis=1)))


def _shares(spectrum: Floats) -> Floats:
    return np.asarray(spectrum / spectrum.sum(axis=1, keepdims=True))


def _autocorrelation(scans: Floats) -> Floats:
    return np.fft.irfft(_spectrum(scans) ** 2, scans.shape[1], axis=1)


def _standardised(scans: Floats) -> Floats:
    return np.asarray((scans - scans.mean(axis=1, keepdims=True)) / scans.std(axis=1, keepdims=True))


def _counts(cells: Floats, bins: int) -> Floats:
    """How many of each row's values fall in each of `bins` boxes, cells being given in units of a box."""
    boxes = np.clip(cells.astype(np.int64), 0, bins - 1)
    return np.asarray((boxes[:, :, None] == np.arange(bins)).sum(axis=1), dtype=np.float64)


def _histogram(bins: int) -> Descriptor:
    return lambda scans: _counts(scans * (bins / world.RANGE), bins)


def _own_histogram(bins: int) -> Descriptor:
    """Boxes from the shortest to the longest ray of each scan."""

    def count(scans: Floats) -> Floats:
        low, span = scans.min(axis=1, keepdims=True), np.ptp(scans, axis=1, keepdims=True)
        return _counts((scans - low) * (bins / span), bins)

    return count


def _gaps(scans: Floats) -> Floats:
    return np.sort(np.abs(scans - np.roll(scans, 1, axis=1)), axis=1)


def _from_extreme(which: Callable[..., Floats]) -> Descriptor:
    """The scan turned so that its longest (or shortest) ray comes first."""

    def turn(scans: Floats) -> Floats:
        n = scans.shape[1]
        order = (which(scans, axis=1)[:, None] + np.arange(n)) % n
        return np.take_along_axis(scans, order.astype(np.int64), axis=1)

    return turn


def _numbers(*statistics: Callable[[Floats], Floats]) -> Descriptor:
    return lambda scans: np.stack([statistic(scans) for statistic in statistics], axis=1)


def mean(scans: Floats) -> Floats:
    return np.asarray(scans.mean(axis=1))


def std(scans: Floats) -> Floats:
    return np.asarray(scans.std(axis=1))


def longest(scans: Floats) -> Floats:
    return np.asarray(scans.max(axis=1))


def shortest(scans: Floats) -> Floats:
    return np.asarray(scans.min(axis=1))


def median(scans: Floats) -> Floats:
    return np.asarray(np.median(scans, axis=1))


def _power_sums(scans: Floats) -> Floats:
    return np.stack([(scans**p).sum(axis=1) for p in (1, 2, 3)], axis=1)


def _gaps_counted(scans: Floats) -> Floats:
    return np.hstack([_histogram(8)(_gaps(scans)), scans.mean(axis=1, keepdims=True)])


def _area_and_perimeter(scans: Floats) -> Floats:
    """Of the polygon that joins the ends of the beams."""
    turn, after = 2.0 * np.pi / scans.shape[1], np.roll(scans, -1, axis=1)
    sides = np.sqrt(scans**2 + after**2 - 2.0 * scans * after * np.cos(turn))
    return np.stack([0.5 * np.sin(turn) * (scans * after).sum(axis=1), sides.sum(axis=1)], axis=1)


def _moments(scans: Floats) -> Floats:
    shape = _standardised(scans)
    return np.stack([mean(scans), scans.var(axis=1), (shape**3).mean(axis=1), (shape**4).mean(axis=1)], axis=1)


DESCRIPTORS: dict[str, Descriptor] = {
    "spectrum": _spectrum,
    "spectrum without mean": lambda scans: _spectrum(scans)[:, 1:],
    "first of the spectrum": lambda scans: _spectrum(scans)[:, 1:6],
    "power": lambda scans: _spectrum(scans) ** 2,
    "shares of the spectrum": lambda scans: _shares(_spectrum(scans)),
    "log spectrum": lambda scans: np.log1p(_spectrum(scans)),
    "bare log spectrum": lambda scans: np.log(_spectrum(scans) + 1e-9),
    "autocorrelation": _autocorrelation,
    "correlation": lambda scans: _autocorrelation(_standardised(scans)),
    "sorted": lambda scans: np.sort(scans, axis=1),
    "quartiles": lambda scans: np.percentile(scans, (0, 25, 50, 75, 100), axis=1).T,
    "gaps": _gaps,
    "mean, std": _numbers(mean, std),
    "shortest, longest": _numbers(shortest, longest),
    "mean, shortest, longest": _numbers(mean, shortest, longest),
    "mean, median": _numbers(mean, median),
    "mean, std, shortest, longest": _numbers(mean, std, shortest, longest),
    "moments": _moments,
    "sums of powers": _power_sums,
    "gaps counted": _gaps_counted,
    "area, perimeter": _area_and_perimeter,
    "longest first": _from_extreme(np.argmax),
    "shortest first": _from_extreme(np.argmin),
    **{f"histogram {bins}": _histogram(bins) for bins in (6, 10, 12, 20, 36)},
    **{f"own histogram {bins}": _own_histogram(bins) for bins in (8, 10, 20)},
}


def _manhattan(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.abs(a[:, None] - b[None]).sum(axis=2))


def _euclidean(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.sqrt(((a[:, None] - b[None]) ** 2).sum(axis=2)))


def _largest(a: Floats, b: Floats) -> Floats:
    return np.asarray(np.abs(a[:, None] - b[None]).max(axis=2))


def _chord(a: Floats, b: Floats) -> Floats:
    """The root of the cosine distance, which is of the order of the noise as the others are."""
    return _euclidean(*(x / np.linalg.norm(x, axis=1, keepdims=True) for x in (a, b)))


NUMBERS: tuple[Callable[[Floats], Floats], ...] = (
    mean, std, longest, shortest, median,
    lambda scans: np.ptp(scans, axis=1),
    lambda scans: (scans**2).sum(axis=1),
    lambda scans: _spectrum(scans)[:, 1],
)  # fmt: skip
"""Single numbers that a student may take for a signature."""


def _signed(descriptor: Descriptor, sign: float) -> Distance:
    """The sum of the differences, in which they make up for one another."""
    return lambda a, b: sign * (descriptor(b).sum(axis=1) - descriptor(a).sum(axis=1)[:, None])


DISTANCES: dict[str, Distance] = {"L1": _manhattan, "L2": _euclidean, "max": _largest, "cosine": _chord}

MISTAKEN: tuple[Distance, ...] = (
    _manhattan, _euclidean, _largest,
    *(_signed(descriptor, sign) for descriptor in (lambda scans: scans, _spectrum) for sign in (1.0, -1.0)),
)  # fmt: skip
"""Distances between scans (m, 36), (p, 36) that usual mistakes make: of bare scans, and of signatures without signs."""
