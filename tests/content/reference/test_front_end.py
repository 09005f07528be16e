"""The complete front end: over several seeds, the trajectory becomes several times better, and the map the true one."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from reference.formats.carmen import LaserLog, parse_flaser
from reference.front_end import FrontEndError, FrontEndSettings, SlamResult, StepNoise, slam
from reference.front_end import tracker as tracking
from reference.front_end.mapper import Mapper
from reference.front_end.tracker import TrackedScan, Tracker
from reference.metrics import absolute_trajectory_error
from reference.occupancy import InverseSensorModel, build_map
from reference.odometry import DifferentialDrive, integrate_poses
from reference.registration import LineCloud, match_clouds
from reference.se2 import compose, relative, wrap_angle
from reference.world.distance_map import distances_to_cells
from reference.world.grid_map import GridMap
from reference.world.scan import Scan
from reference.world.scenes import random_ring
from reference.world.simulation import SimulatedLidar, SimulatedRun, motions_through_waypoints, simulate

Floats = NDArray[np.float64]
SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))]


@cache
def journey(seed: int) -> tuple[GridMap, SimulatedRun]:
    """A little more than once around a ring of corridors, by a robot that drifts by about a metre."""
    rng = np.random.default_rng(seed)
    place = random_ring(rng, (120, 160), corridor=24)
    height, width = place.shape
    corners = place.to_world([(24, 24), (width - 24, 24), (width - 24, height - 24), (24, height - 24), (24, 24)])
    waypoints = np.vstack([corners[1:], corners[1:2]])
    motions = motions_through_waypoints([*corners[0], 0.0], waypoints, 0.15, 0.3)
    drive = DifferentialDrive(0.3, sigma_per_root_metre=0.015)
    return place, simulate(place, motions, [*corners[0], 0.0], drive, SimulatedLidar.full_turn(120, 5.0, 0.01), rng)


@cache
def finished(seed: int) -> SlamResult:
    _, run = journey(seed)
    return slam(scans_of(run), run.odometry, start=run.truth[0], resolution=0.05)


def scans_of(run: SimulatedRun) -> list[Scan]:
    return [run.scan(k) for k in range(len(run))]


@pytest.mark.parametrize("seed", SEEDS)
def test_the_trajectory_is_several_times_better_than_odometry(seed: int) -> None:
    _, run = journey(seed)
    found = finished(seed)
    before, after = (absolute_trajectory_error(run.truth, p, "first").rmse for p in (run.odometry, found.T_map_robot))
    assert before > 0.2
    assert after < before / 10
    np.testing.assert_allclose(found.T_map_robot[0], run.truth[0], atol=1e-9)
    assert found.T_map_robot.shape == run.truth.shape


@pytest.mark.parametrize("seed", SEEDS)
def test_every_closure_that_counts_is_true(seed: int) -> None:
    _, run = journey(seed)
    found = finished(seed)
    assert len(found.closures) >= 5
    for closure in found.closures:
        truth = relative(run.truth[found.keys[closure.i]], run.truth[found.keys[closure.j]])
        gap = closure.match.T_a_b - truth
        assert np.abs(gap[:2]).max() < 0.1
        assert abs(wrap_angle(float(gap[2]))) < 0.03
        assert not closure.refusal
    assert all(closure.refusal for closure in found.refused)
    assert len(found.links) == len(found.keys) - 1
    assert len(found.graph.i) == len(found.links) + len(found.closures)
    assert found.chi2 < 3 * len(found.graph.i)


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
    distances = distances_to_cells(np.pad(place.occupied, 40, constant_values=False)) * place.resolution
    y, x = np.nonzero(found.occupied)
    cells = np.floor(place.to_cells(found.to_world(np.column_stack([x, y]) + 0.5))).astype(int) + 40
    cells = np.clip(cells, 0, np.array(distances.shape)[::-1] - 1)
    return float(np.quantile(distances[cells[:, 1], cells[:, 0]], 0.9))


@pytest.mark.parametrize("mount", [(0.1, -0.05, 0.3), (-0.2, 0.0, np.pi)])
def test_half_a_turn_of_a_lidar_mounted_anywhere_is_enough(mount: Any) -> None:
    """From a lidar at `T_robot_laser` that looks over half a turn, ahead or behind, without a loop to help."""
    place, run = journey(0)
    count = 140
    lidar = SimulatedLidar(np.deg2rad(np.arange(-90.0, 90.0, 2.0)), 5.0, 0.01)
    truth = run.truth[:count]
    ranges = lidar.measure_ranges(place, np.array([compose(pose, mount) for pose in truth]), np.random.default_rng(3))
    scans = [Scan(row, lidar.angles, lidar.max_range) for row in ranges]
    found = slam(scans, run.odometry[:count], T_robot_laser=mount, start=truth[0], resolution=0.1)
    before, after = (
        absolute_trajectory_error(truth, p, "none").rmse for p in (run.odometry[:count], found.T_map_robot)
    )
    assert after < min(0.3, before / 3)


def test_the_bias_of_the_wheels_is_learned_on_the_way() -> None:
    """A robot whose right wheel is 4 % too small thinks that it turns left: half of what it misses is known soon."""
    _, run = journey(0)
    drive = DifferentialDrive(0.3)
    wheels = run.wheels[:200] * np.array([1.0, 1.04])
    odometry = integrate_poses(drive, wheels, run.truth[0])
    found = slam(scans_of(run)[:201], odometry, start=run.truth[0], resolution=0.1)
    off = 0.02 / 0.15  # radians too many a metre
    assert found.bias[0, 2] == pytest.approx(-off, rel=0.3)
    assert absolute_trajectory_error(run.truth[:201], found.T_map_robot, "none").rmse < 0.1


def test_without_a_loop_the_scans_still_help() -> None:
    _, run = journey(0)
    found = slam(scans_of(run)[:40], run.odometry[:40], start=run.truth[0])
    assert found.closures == ()
    assert all(link.match is not None for link in found.links)
    assert np.abs(found.T_map_robot - run.truth[:40])[:, :2].max() < 0.1


def test_key_poses_are_far_enough_apart() -> None:
    found, rule = finished(0), FrontEndSettings()
    steps = np.array([link.T_key_robot for link in found.links])
    far = np.hypot(steps[:, 0], steps[:, 1]) >= rule.key_distance
    assert np.all(far | (np.abs(steps[:, 2]) >= rule.key_turn))
    assert found.keys[0] == 0
    assert np.all(np.diff(found.keys) > 0)


def test_loops_outvote_odometry_that_is_too_sure_of_itself() -> None:
    """One step errs by 40 times its deviation: odometry contradicts each true loop, but eighteen agree."""
    _, run = journey(0)
    keys = range(0, len(run), 3)
    truth, clouds = run.truth[keys], [LineCloud.from_scan(run.scan(k), np.zeros(3)) for k in keys]
    steps = relative(truth[:-1], truth[1:])
    steps[20] += np.array([0.4, 0.1, 0.0])
    sure = np.diag(np.array([0.01, 0.01, 0.003]) ** -2.0)
    mapper = Mapper(FrontEndSettings(), truth[0], clouds[0])
    for cloud, step in zip(clouds[1:], steps, strict=True):
        mapper.add(cloud, TrackedScan(step, sure, None))
    mapper.settle_closures()
    assert len(mapper.closures) > 10
    assert max(closure.disagreement for closure in mapper.closures) > FrontEndSettings().gate
    assert not any(closure.refusal for closure in mapper.closures)
    assert absolute_trajectory_error(truth, np.array(mapper.T_map_keys)).rmse < 0.12


@pytest.mark.parametrize(
    ("gap", "overlap", "believed"),
    [
        ((0.1, 0.0, 0.0), 0.6, True),
        ((1.0, 0.9, 0.0), 0.6, False),
        ((0.0, 0.0, 0.9), 0.6, False),
        ((0.0, 0.0, 0.9), 0.9, True),
        ((0.1, 0.0, 0.0), 0.4, False),
        ((0.02, 0.0, 0.0), 0.4, True),
        ((0.02, 0.0, 0.0), 0.2, False),
    ],
    ids=[
        "near",
        "slid away",
        "turned away",
        "the wheels slipped",
        "little in common",
        "as expected, around a corner",
        "next to nothing in common",
    ],
)
def test_a_match_needs_the_more_points_the_farther_it_leads_from_odometry(
    gap: tuple[float, float, float], overlap: float, believed: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    _, run = journey(0)
    cloud = LineCloud.from_scan(run.scan(0), np.zeros(3))
    right = match_clouds(cloud, cloud, np.zeros(3))
    tracker = Tracker(FrontEndSettings())
    tracker.set_submap([np.zeros(3)], [cloud])
    answer = replace(right, T_a_b=np.array(gap), overlap=overlap)
    monkeypatch.setattr(tracking, "match_clouds", lambda *_, **__: answer)
    assert (tracker.track(cloud, np.zeros(3)).match is not None) == believed


@settings(deadline=None, max_examples=15)
@given(seed=st.integers(0, 2**32 - 1))
def test_scans_that_show_nothing_of_one_another_are_mapped_by_odometry(seed: int) -> None:
    """Noise, gaps and empty scans: whatever matches nothing is left to the wheels, and no step fails."""
    rng = np.random.default_rng(seed)
    kinds = rng.choice(["noise", "blind", "few", "far"], 12)
    odometry = np.cumsum(rng.normal(0, [0.3, 0.3, 0.2], (12, 3)), axis=0)
    scans = [a_strange_scan(kind, rng) for kind in kinds]
    found = slam(scans, odometry, resolution=0.2)
    assert np.isfinite(found.T_map_robot).all()
    if not {"noise", "far"} & set(kinds):
        np.testing.assert_allclose(
            relative(odometry[0], odometry[-1]), relative(*found.T_map_robot[[0, -1]]), atol=1e-9
        )


def a_strange_scan(kind: str, rng: np.random.Generator) -> Scan:
    angles = np.deg2rad(np.arange(-90.0, 90.0, 3.0))
    readings = {
        "noise": rng.uniform(0.1, 9.0, len(angles)),
        "blind": np.full(len(angles), np.nan),
        "few": np.where(np.arange(len(angles)) < 5, 2.0, np.inf),
        "far": np.full(len(angles), 7.9),
    }
    return Scan.from_sensor(readings[kind], angles, 8.0, 0.2)


@cache
def intel(dataset_text: bytes) -> tuple[LaserLog, SlamResult]:
    log = parse_flaser(dataset_text, 40.0)
    return log, slam(log.scans[:120], log.wheel_poses()[:120], resolution=0.1)


def test_the_intel_log_is_mapped_from_the_robot_s_own_odometry(dataset: Callable[[str], bytes]) -> None:
    """120 scans: the wheels alone end 11 m off; the poses of the log are those of another mapper."""
    log, found = intel(dataset("laser/intel.gfs.log"))
    error = absolute_trajectory_error(log.T_odom_robot[:120], found.T_map_robot)
    assert absolute_trajectory_error(log.T_odom_robot[:120], log.wheel_poses()[:120]).rmse > 5.0
    assert error.rmse < 0.1
    assert found.bias[0, 2] > 0.03


@pytest.mark.slow
def test_the_whole_intel_log_is_mapped(dataset: Callable[[str], bytes]) -> None:
    log = parse_flaser(dataset("laser/intel.gfs.log"), 40.0)
    found = slam(log.scans, log.wheel_poses(), resolution=0.1)
    assert absolute_trajectory_error(log.T_odom_robot, found.T_map_robot).rmse < 0.1
    for closure in found.closures:
        truth = relative(log.T_odom_robot[found.keys[closure.i]], log.T_odom_robot[found.keys[closure.j]])
        assert np.hypot(*relative(truth, closure.match.T_a_b)[:2]) < 0.5


SCAN = Scan.full_turn(np.ones(20), 5.0)


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("scans", lambda: slam([SCAN], np.zeros((1, 3)))),
        ("T_odom_robot", lambda: slam([SCAN, SCAN], np.zeros((3, 3)))),
        ("T_odom_robot", lambda: slam([SCAN, SCAN], [[0, 0, 0], [np.nan, 0, 0]])),
        ("T_robot_laser", lambda: slam([SCAN, SCAN], np.zeros((2, 3)), T_robot_laser=(0, 0))),
        ("start", lambda: slam([SCAN, SCAN], np.zeros((2, 3)), start=(0, 0, np.inf))),
        ("gate", lambda: FrontEndSettings(gate=0.0)),
        ("min_gap", lambda: FrontEndSettings(min_gap=1)),
        ("tries", lambda: FrontEndSettings(tries=0)),
        ("voters", lambda: FrontEndSettings(voters=0)),
        ("loop_overlap", lambda: FrontEndSettings(loop_overlap=1.1)),
        ("metres", lambda: StepNoise(metres=0.0)),
        ("per_metre", lambda: StepNoise(per_metre=-0.1)),
    ],
)
def test_what_makes_no_journey_is_refused_by_name(argument: str, call: Any) -> None:
    with pytest.raises(FrontEndError) as caught:
        call()
    assert caught.value.argument == argument
