"""Resampling, a step of localisation, EKF-SLAM: ours beside filterpy and beside what tutorials write, in one process.

    OPENBLAS_NUM_THREADS=1 PYTHONPATH=. python tests/benchmarks/bench_filters.py [rounds]

The naive versions are of our own writing, after the usual tutorials; filterpy (the extra `benchmarks`) is left out
where it is missing. Prints medians, deciles, ratios, and how both forms of EKF-SLAM grow, all in processor time, which
other work on the machine disturbs less; OPENBLAS_NUM_THREADS=1 keeps it the time of one core.
"""

from __future__ import annotations

import math
import statistics
import sys
import time
from collections.abc import Callable
from itertools import count

import numpy as np

from reference.ekf_slam import EkfSlam, SlamNoise, Update, update_covariance_in_place, updated_covariance_textbook
from reference.filters.resampling import (
    comb_resampling,
    multinomial_resampling,
    residual_resampling,
    stratified_resampling,
)
from reference.localisation.mcl import MonteCarloLocalization, uniform_poses
from reference.sensors.beam import BeamModel, BeamSensor
from reference.sensors.likelihood_field import LikelihoodField
from reference.world.scan import Scan
from reference.world.scenes import random_building
from tests.benchmarks.measure import Contender, Goal, Pace, Row, figure, interleave, median, table

PARTICLES, BEAMS, MILLION = 500, 30, 1_000_000
OFFSET = 0.37
SAMPLED_EVERY = 10
NS_A_PARTICLE = 1e6 / MILLION  # of milliseconds


def timed(name: str, action: Callable[[], object], every: int = 1) -> Contender:
    def run() -> float:
        start = time.process_time()
        action()
        return time.process_time() - start

    return Contender(name, run, every)


def compare(title: str, contenders: list[Contender], rounds: int, unit: str, scale: float) -> None:
    """The first contender is ours: ratios are to it."""
    interleave(contenders, rounds)
    ours = median(contenders[0].own)
    rows = []
    for contender in contenders:
        deciles = statistics.quantiles(contender.own, n=10) if len(contender.own) > 1 else contender.own * 9
        rows.append(
            [
                contender.name,
                figure(scale * median(contender.own)),
                f"{figure(scale * deciles[0])} … {figure(scale * deciles[-1])}",
                figure(median(contender.own) / ours),
            ]
        )
    print(f"\n{title}\n")
    print(table(["", unit, "p10 … p90", "ratio to ours"], rows))


def bare_formula(weights: np.ndarray) -> np.ndarray:
    """Counting in place of searching, without checks or blocks: wrong when a sum is off by rounding."""
    n = weights.size
    return np.cumsum(np.bincount(np.ceil(n * np.cumsum(weights) - OFFSET).astype(np.int64), minlength=n)[:n])


def searched(weights: np.ndarray) -> np.ndarray:
    return np.searchsorted(np.cumsum(weights), (np.arange(weights.size) + OFFSET) / weights.size)


def tutorial_comb(weights: list[float]) -> list[int]:
    """The loop of the textbook's table 4.4."""
    n, i, total, ancestors = len(weights), 0, weights[0], []
    for m in range(n):
        while total < (m + OFFSET) / n and i < n - 1:
            i += 1
            total += weights[i]
        ancestors.append(i)
    return ancestors


def resampling_contenders() -> list[Contender]:
    weights = np.random.default_rng(0).random(MILLION)
    weights /= weights.sum()
    assert np.array_equal(comb_resampling(weights, OFFSET).ancestors, searched(weights))
    rng, listed = np.random.default_rng(1), weights.tolist()
    contenders = [
        timed("systematic, ours", lambda: comb_resampling(weights, OFFSET)),
        timed("stratified, ours", lambda: stratified_resampling(weights, rng)),
        timed("residual, ours", lambda: residual_resampling(weights, rng), 5),
        timed("multinomial, ours", lambda: multinomial_resampling(weights, rng), 5),
        timed("systematic: the bare formula", lambda: bare_formula(weights)),
        timed("systematic: searchsorted", lambda: searched(weights)),
        timed("systematic: the textbook's loop", lambda: tutorial_comb(listed), 5),
    ]
    try:
        from filterpy.monte_carlo import systematic_resample
    except ImportError:
        print("filterpy is not installed: left out")
    else:
        contenders.append(timed("systematic: filterpy", lambda: systematic_resample(weights), 5))
    return contenders


def resampling(rounds: int) -> None:
    compare("Resampling a million particles", resampling_contenders(), rounds, "ns a particle", NS_A_PARTICLE)


def naive_step(
    poses: list[list[float]], scan: Scan, distances: list[list[float]], resolution: float, rng: np.random.Generator
) -> list[list[float]]:
    """One particle and one beam at a time: move, weigh by the likelihood field, resample."""
    weights, moved = [], []
    for start_x, start_y, start_heading in poses:
        turn, advance = rng.normal(0.1, 0.02), rng.normal(0.3, 0.03)
        x, y = start_x + advance * math.cos(start_heading), start_y + advance * math.sin(start_heading)
        heading = start_heading + turn
        likelihood = 1.0
        for z, angle in zip(scan.ranges.tolist(), scan.angles.tolist(), strict=True):
            column = math.floor((x + z * math.cos(heading + angle)) / resolution)
            row = math.floor((y + z * math.sin(heading + angle)) / resolution)
            inside = 0 <= row < len(distances) and 0 <= column < len(distances[0])
            d = distances[row][column] if inside else math.inf
            likelihood *= 0.9 * math.exp(-0.5 * (d / 0.2) ** 2) / (0.2 * math.sqrt(2 * math.pi)) + 0.01
        moved.append([x, y, heading])
        weights.append(likelihood)
    total = sum(weights)
    return [list(moved[i]) for i in tutorial_comb([weight / total for weight in weights])]


def localisation_contenders() -> list[Contender]:
    rng = np.random.default_rng(2)
    grid_map = random_building(rng, (2, 3), resolution=0.2)
    start = uniform_poses(grid_map, PARTICLES, rng)
    angles = 2.0 * np.pi * np.arange(BEAMS) / BEAMS
    scan = Scan(grid_map.cast_scans(start[:1], angles, 8.0)[0], angles, 8.0)
    move = np.array([0.3, 0.01, 0.1])
    field = LikelihoodField(grid_map, sigma=0.2, max_range=8.0)

    def localiser(sensor: LikelihoodField | BeamSensor) -> MonteCarloLocalization:
        return MonteCarloLocalization(grid_map, sensor, start, rng, threshold=1.0)

    by_field, by_beams = localiser(field), localiser(BeamSensor(grid_map, BeamModel(8.0)))

    def step(robot: MonteCarloLocalization) -> None:
        robot.states = start
        robot.predict(move)
        robot.correct(scan)

    distances = grid_map.distances_to_wall.tolist()
    return [
        timed("likelihood field: a whole step, ours", lambda: step(by_field)),
        timed("its weighing alone", lambda: field.log_likelihood(start, scan)),
        timed("beam model with ray casting: a whole step, ours", lambda: step(by_beams), 10),
        timed(
            "likelihood field: particle by particle",
            lambda: naive_step(start.tolist(), scan, distances, grid_map.resolution, rng),
            20,
        ),
    ]


def localisation(rounds: int) -> None:
    title = f"Localisation: {PARTICLES} particles, {BEAMS} beams (move, weigh, resample at every step)"
    compare(title, localisation_contenders(), 10 * rounds, "ms", 1.0)


def one_correction(landmarks: int, update: Update) -> Callable[[], object]:
    """The correction of one covariance by one sighting, again and again."""
    rng, size = np.random.default_rng(landmarks), 3 + 2 * landmarks
    robot = EkfSlam(SlamNoise(0.02, 0.01, 0.05, 0.02))
    root = rng.normal(size=(size, 8))
    robot.mean, robot.covariance = rng.normal(size=size), np.asfortranarray(root @ root.T + np.eye(size))
    sighting = robot.predict_sighting(3, np.array([3.0, 0.2]))
    return lambda: update(robot.covariance, sighting, robot.noise.sighting_covariance)


def slam(rounds: int) -> None:
    sizes = {update_covariance_in_place: (500, 1000, 2000), updated_covariance_textbook: (250, 500, 1000)}
    names = {update_covariance_in_place: "rank two, in place", updated_covariance_textbook: "textbook, (I - K H) P"}
    every = {update_covariance_in_place: 1, updated_covariance_textbook: 5}
    contenders = {
        (update, n): timed(f"{names[update]}, {n} landmarks", one_correction(n, update), every[update])
        for update, counts in sizes.items()
        for n in counts
    }
    shared = contenders[update_covariance_in_place, 500], contenders[updated_covariance_textbook, 500]
    rest = [contender for contender in contenders.values() if contender not in shared]
    compare("EKF-SLAM: one correction of the covariance", [*shared, *rest], rounds, "ms", 1.0)
    for update, counts in sizes.items():
        # The least disturbed times: what the slope is about is the computing, not its company.
        times = [min(contenders[update, n].own) for n in counts]
        slope = np.polyfit(np.log(counts), np.log(times), 1)[0]
        print(f"{names[update]}: time grows as n to the power {slope:.2f}")


def rows(rounds: int) -> list[Row]:
    """The first contender of each is ours; times are of the processor, and normalised by its clock."""
    combed, located = resampling_contenders(), localisation_contenders()
    without = "" if any("filterpy" in one.name for one in combed) else "filterpy is not installed"
    asked = (
        ("systematic resampling, a million particles", combed, 1, "ns a particle", NS_A_PARTICLE, 8.0, without),
        (f"localisation step, {PARTICLES} particles × {BEAMS} beams", located, 10, "ms", 1.0, 0.25, ""),
    )
    made = []
    for subject, contenders, more, unit, scale, goal, why in asked:
        pace = Pace()
        contenders[0].action = _beside(pace, contenders[0].action)
        interleave(contenders, more * rounds)
        spent = scale * median(contenders[0].own)
        told = ", ".join(f"{one.name} {figure(scale * median(one.own))}" for one in contenders[1:])
        normal = spent * pace.processor
        made.append(Row(subject, unit, spent, normal, normal, peers=told, goal=Goal(goal), why=why))
    return made


def _beside(pace: Pace, action: Callable[[], float]) -> Callable[[], float]:
    """The same, with the pace taken now and then."""
    turns = count()

    def run() -> float:
        if next(turns) % SAMPLED_EVERY == 0:
            pace.sample()
        return action()

    return run


if __name__ == "__main__":
    repeats = int(sys.argv[1]) if len(sys.argv) > 1 else 30
    resampling(repeats)
    localisation(repeats)
    slam(repeats)
