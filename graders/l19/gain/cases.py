"""The measurements that submissions are graded on: by hand first, so that known mistakes fail whatever is drawn."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from graders.core.contract.values import Arguments, Floats


def row(*values: float) -> Floats:
    return np.array(values, dtype=np.float64)


def gains_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    yield 4.0, 1.0
    yield 1.0, 3.0
    yield 2.0, 2.0
    yield 0.25, 2.25
    yield 6.25, 0.01
    yield 1e-4, 2e-4
    yield 3e-5, 4000.0
    for _ in range(4):
        v, r = np.round(rng.uniform(0.05, 8.0, 2), 2)
        yield float(v), float(r)


def gains_at_the_ends(rng: np.random.Generator) -> Iterator[Arguments]:
    """An exact sensor, and a belief without doubt; never both."""
    yield 2.0, 0.0
    yield 0.0, 3.0
    yield 0.04, 0.0
    yield 0.0, 0.5


def opinions_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Two of unequal worth, then two alike, three, one alone."""
    yield row(10.0, 12.0), row(4.0, 1.0)
    yield row(1.0, 5.0), row(3.0, 3.0)
    yield row(2.0, -1.0, 6.0), row(2.0, 4.0, 0.5)
    yield row(7.0), row(2.5)
    yield row(1.0, 2.0), row(1e-4, 3e-4)
    yield row(5000.0, -400.0), row(900.0, 1e4)


def any_opinions(rng: np.random.Generator) -> Iterator[Arguments]:
    yield row(-3.5, -2.25, -4.0, -3.25, -2.0), row(0.36, 2.25, 1.5, 0.09, 5.0)
    for count in (2, 3, 4, 6, 8):
        yield _readings(rng, count)


def chains_by_hand(rng: np.random.Generator) -> Iterator[Arguments]:
    """Two readings, then more; one exact, after which nothing is doubted any more."""
    yield 10.0, 4.0, row(12.0, 11.0), row(1.0, 0.8)
    yield -2.0, 9.0, row(4.0), row(3.0)
    yield 0.0, 2.0, row(3.0, -1.0, 2.0, 5.0), row(6.0, 0.5, 2.0, 9.0)
    yield 200.0, 1e-4, row(-300.0, 5.0, 7.0), row(2e-4, 900.0, 1e-5)
    yield 1.0, 3.0, row(2.0, 4.0, 7.0), row(1.5, 0.0, 2.0)


def any_chains(rng: np.random.Generator) -> Iterator[Arguments]:
    yield 6.5, 2.25, row(5.25, 4.0, 6.75, 5.5, 4.25), row(0.49, 3.5, 1.25, 0.16, 7.0)
    for count in (3, 5, 8, 12):
        m, v = np.round((rng.uniform(-9.0, 9.0), rng.uniform(0.05, 8.0)), 2)
        yield float(m), float(v), *_readings(rng, count)


def _readings(rng: np.random.Generator, count: int) -> tuple[Floats, Floats]:
    place = rng.uniform(-9.0, 9.0)
    variances = np.round(rng.uniform(0.05, 6.0, count), 2)
    return np.round(place + rng.normal(size=count) * np.sqrt(variances), 2) + 0.0, variances


def are_gains(args: Arguments) -> bool:
    return bool(args[0] > 0.0 and args[1] > 0.0)


def are_ends(args: Arguments) -> bool:
    return bool(min(args) == 0.0 and max(args) > 0.0)


def are_opinions(args: Arguments) -> bool:
    """Are these measurements that the statement allows, and that differ?"""
    measured, variances = args
    return bool(np.min(variances) > 0.0 and (len(measured) == 1 or np.ptp(measured) > 0.0))


def is_chain(args: Arguments) -> bool:
    """Is it a chain without an exact sensor, of which the first reading says something new?"""
    m, v, measured, variances = args
    return bool(v > 0.0 and np.min(variances) > 0.0 and measured[0] != m)
