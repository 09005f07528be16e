"""What cours 1 and cours 2 measure: three filters in a corridor, and the likelihood of a range finder."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtr

from curriculum.l20.figures._plan import module_map
from reference.world.scan import full_turn_angles
from reference.world.simulation import SimulatedLidar
from tests.content.curriculum.measured.tables import Cell

Floats = NDArray[np.float64]

RUNS = 1000


def bell(x: Floats, mean: float, sigma: float) -> Floats:
    return np.asarray(np.exp(-((x - mean) ** 2) / (2.0 * sigma**2)))


def corridor(step: float) -> tuple[Floats, Floats, Floats, Floats]:
    """Ten metres cut in cells: their centres, the belief predicted, the likelihood and the belief corrected."""
    edges = np.arange(0.0, 10.0 + step / 2, step)
    x = (edges[:-1] + edges[1:]) / 2.0
    belief = np.diff(ndtr(edges - 2.0)) @ np.diff(ndtr((edges - x[:, None] - 3.0) / 0.5))
    belief /= belief.sum()
    likelihood = bell(10.0 - x, 4.4, 0.5)
    corrected = belief * likelihood
    return x, belief, likelihood, corrected / corrected.sum()


def grid_by_hand() -> Iterator[list[Cell]]:
    _, predicted, likelihood, corrected = corridor(1.0)
    for row in (predicted, likelihood / likelihood.max(), corrected):
        yield [float(value) for value in row[3:8]]


def particles(count: int) -> tuple[float, float, float]:
    """Mean and deviation of the answer over many runs, and the deviation that is claimed."""
    rng = np.random.default_rng(0)
    answers, claims = [], []
    for _ in range(RUNS):
        p = rng.normal(2, 1, count) + 3 + rng.normal(0, 0.5, count)
        w = bell(10 - p, 4.4, 0.5)
        w /= w.sum()
        answers.append(w @ p)
        claims.append(np.sqrt(w @ (p - w @ p) ** 2))
    return float(np.mean(answers)), float(np.std(answers)), float(np.mean(claims))


def three_filters() -> Iterator[list[Cell]]:
    yield [5.5, float(np.sqrt(1.25 / 6.0))]
    for step in (1.0, 0.5, 0.1):
        x, _, _, belief = corridor(step)
        mean = float(belief @ x)
        yield [mean, float(np.sqrt(belief @ (x - mean) ** 2))]
    for count in (100, 1000, 10_000):
        mean, spread, claim = particles(count)
        yield [(mean, spread), claim]


HIT, SHORT, BEYOND, STRAY = 0.7, 0.1, 0.1, 0.1
SIGMA, RATE, RANGE = 0.2, 0.5, 12.0


def mass() -> Iterator[list[Cell]]:
    """The formula of the course, integrated over [0, RANGE]."""

    def total(expected: float) -> float:
        inside = ndtr((RANGE - expected) / SIGMA) - ndtr(-expected / SIGMA)
        return float(HIT * inside + SHORT * (1.0 - np.exp(-RATE * expected)) + BEYOND + STRAY)

    yield [total(expected) for expected in (0.1, 0.5, 1.0, 5.0, 11.0, 12.0)]


def log_mixture(z: Floats, expected: Floats) -> float:
    hit = bell(z - expected, 0.0, SIGMA) / (SIGMA * np.sqrt(2 * np.pi))
    p = HIT * hit + SHORT * RATE * np.exp(-RATE * z) * (z <= expected)
    return float(np.log(p + BEYOND * (z >= RANGE) + STRAY / RANGE).sum())


def log_bell(z: Floats, expected: Floats) -> float:
    return float((-0.5 * ((z - expected) / SIGMA) ** 2 - np.log(SIGMA * np.sqrt(2 * np.pi))).sum())


def errors_of_x(seed: int = 0) -> Iterator[list[Cell]]:
    """The decimal logarithm of the likelihood of one scan, from where the robot is and farther along x."""
    angles, places = full_turn_angles(360), [(10.5 + away, 7.5, 0.0) for away in (0.0, 0.1, 0.5, 1.0)]
    expected = module_map().cast_scans(places, angles, RANGE)
    scan = SimulatedLidar.full_turn(360, RANGE, SIGMA).add_noise(expected[0], np.random.default_rng(seed))
    for model, kept in ((log_bell, 1), (log_mixture, 1), (log_mixture, 12)):
        yield [model(scan[::kept], one[::kept]) / float(np.log(10.0)) for one in expected]


def overconfidence() -> Iterator[list[Cell]]:
    """Sigma 10 cm a ray, 5 cm common to all: the deviation claimed, the true one, how often the truth is within two."""
    for rays in (360, 30, 4):
        claimed, true = 10.0 / np.sqrt(rays), np.sqrt(5.0**2 + 10.0**2 / rays)
        yield [float(claimed), float(true), float(100.0 * (2.0 * ndtr(2.0 * claimed / true) - 1.0))]
