"""The complete front end: over several seeds, the trajectory becomes several times better, and the map the true one."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from reference.front_end import FrontEndError, Settings, Slam, key_poses, slam
from reference.metrics import absolute_trajectory_error
from reference.occupancy import InverseSensorModel, build_map
from reference.odometry import DifferentialDrive
from reference.se2 import relative, wrap_angle
from reference.world.distance_map import distance_to
from reference.world.grid_map import GridMap
from reference.world.scan import Scan
from reference.world.scenes import ring
from reference.world.simulation import Lidar, Run, motions_through, simulate

Floats = NDArray[np.float64]
SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))]


@cache
def journey(seed: int) -> tuple[GridMap, Run]:
    """A little more than once around a ring of corridors, by a robot that drifts by about a metre."""
    rng = np.random.default_rng(seed)
    place = ring(rng, (120, 160), corridor=24)
    height, width = place.shape
    corners = place.to_world([(24, 24), (width - 24, 24), (width - 24, height - 24), (24, height - 24), (24, 24)])
    waypoints = np.vstack([corners[1:], corners[1:2]])
    motions = motions_through([*corners[0], 0.0], waypoints, 0.15, 0.3)
    drive = DifferentialDrive(0.3, sigma_per_root_metre=0.015)
    return place, simulate(place, motions, [*corners[0], 0.0], drive, Lidar.full_turn(120, 5.0, 0.01), rng)


@cache
def finished(seed: int) -> Slam:
    _, run = journey(seed)
    return slam(scans_of(run), run.wheels, run.drive, start=run.truth[0], settings=Settings(tries=2))


def scans_of(run: Run) -> list[Scan]:
    return [run.scan(k) for k in range(len(run))]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_trajectory_is_several_times_better_than_odometry(seed: int) -> None:
    _, run = journey(seed)
    found = finished(seed)
    before, after = (absolute_trajectory_error(run.truth, p, "first").rmse for p in (run.odometry, found.poses))
    assert before > 0.2
    assert after < before / 10
    np.testing.assert_allclose(found.odometry, run.odometry, atol=1e-9)
    np.testing.assert_allclose(found.poses[0], run.truth[0], atol=1e-9)
    assert found.poses.shape == run.truth.shape


@pytest.mark.parametrize("seed", SEEDS)
def test_every_closure_that_counts_is_true(seed: int) -> None:
    _, run = journey(seed)
    found = finished(seed)
    assert len(found.closures) >= 5
    for closure in found.closures:
        truth = relative(run.truth[found.keys[closure.i]], run.truth[found.keys[closure.j]])
        gap = closure.match.T_a_b - truth
        assert np.abs(gap[:2]).max() < 0.05
        assert abs(wrap_angle(float(gap[2]))) < 0.03
        assert not closure.refused
    assert all(closure.refused for closure in found.refused)
    assert len(found.graph.i) == len(found.keys) - 1 + len(found.links) + len(found.closures)
    assert found.chi2 < 5 * 3 * len(found.graph.i)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_map_is_close_to_the_true_one_and_that_of_odometry_is_not(seed: int) -> None:
    place, run = journey(seed)
    found = finished(seed)
    blurred = build_map(scans_of(run), run.odometry, 0.05, model=InverseSensorModel(once_a_scan=True))
    mapped, drifted = found.grid.to_grid_map(), blurred.to_grid_map()
    assert likeness(place, mapped) > 0.8
    assert likeness(place, drifted) < 0.7
    assert wall_error(place, mapped) < 0.11
    assert wall_error(place, drifted) > 0.3


def likeness(place: GridMap, found: GridMap) -> float:
    """Intersection over union of the free cells."""
    y, x = np.indices(found.shape).reshape(2, -1)
    truly = place.is_free(found.to_world(np.column_stack([x, y]) + 0.5)).reshape(found.shape)
    return float((truly & found.free).sum() / (place.free.sum() + (found.free & ~truly).sum()))


def wall_error(place: GridMap, found: GridMap) -> float:
    """How far, in metres, nine in ten of the walls found are from a true one at most."""
    distances = distance_to(np.pad(place.occupied, 40, constant_values=False)) * place.resolution
    y, x = np.nonzero(found.occupied)
    cells = np.floor(place.to_cells(found.to_world(np.column_stack([x, y]) + 0.5))).astype(int) + 40
    cells = np.clip(cells, 0, np.array(distances.shape)[::-1] - 1)
    return float(np.quantile(distances[cells[:, 1], cells[:, 0]], 0.9))


def test_without_a_loop_the_scans_still_help() -> None:
    _, run = journey(0)
    found = slam(scans_of(run)[:40], run.wheels[:39], run.drive, start=run.truth[0])
    assert found.closures == ()
    assert len(found.links) > 3
    assert np.abs(found.poses - run.truth[:40])[:, :2].max() < 0.1


def test_key_poses_are_far_enough_apart() -> None:
    _, run = journey(1)
    keys = key_poses(run.odometry, Settings())
    steps = np.diff(run.odometry[keys], axis=0)
    far = np.hypot(steps[:, 0], steps[:, 1]) >= 0.4
    assert np.all(far | (np.abs(wrap_angle(steps[:, 2])) >= 0.6))
    assert keys[0] == 0


SCAN = Scan.full_turn(np.ones(20), 5.0)
DRIVE = DifferentialDrive(0.3, sigma=0.01)


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("scans", lambda: slam([SCAN], np.zeros((0, 2)), DRIVE)),
        ("scans", lambda: slam([SCAN, Scan.full_turn([1.0], 5.0)], np.zeros((1, 2)), DRIVE)),
        ("scans", lambda: slam([Scan([], [], 5.0)] * 2, np.zeros((1, 2)), DRIVE)),
        ("wheels", lambda: slam([SCAN, SCAN], np.zeros((2, 2)), DRIVE)),
        ("wheels", lambda: slam([SCAN, SCAN], [[np.nan, 0]], DRIVE)),
        ("gate", lambda: Settings(gate=0.0)),
        ("min_gap", lambda: Settings(min_gap=1)),
        ("tries", lambda: Settings(tries=0)),
    ],
)
def test_what_makes_no_journey_is_refused_by_name(argument: str, call: Any) -> None:
    with pytest.raises(FrontEndError) as caught:
        call()
    assert caught.value.argument == argument
