"""Occupancy: the sum of Theorem 2 against Bayes by hand, cells against a marched ray, maps against the world."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from reference.errors import InvalidArgumentError
from reference.formats.carmen import LogError, beam_angles, parse_flaser
from reference.occupancy import (
    InverseSensorModel,
    OccupancyError,
    OccupancyGrid,
    build_map,
    log_odds,
    probability_of_log_odds,
)
from reference.world.distance_map import distances_to_cells
from reference.world.grid_map import GridMap
from reference.world.ray_cells import crossed_cells
from reference.world.raycast import cast_rays
from reference.world.scan import Scan, full_turn_angles

SEVENTY = math.log(7 / 3)
seeds = st.integers(0, 2**32 - 1)


@given(st.floats(1e-9, 1 - 1e-9), st.floats(-700, 700))
def test_log_odds_and_probabilities_are_inverse(p: float, value: float) -> None:
    assert float(probability_of_log_odds(log_odds(p))) == pytest.approx(p, rel=1e-9)
    assert float(probability_of_log_odds(value) + probability_of_log_odds(-value)) == pytest.approx(1.0)


@given(
    st.fractions("1/100", "99/100"),
    st.lists(st.tuples(st.sampled_from([1, 0]), st.fractions("1/20", "19/20")), max_size=12),
)
def test_theorem_2_the_sum_is_bayes(prior: Fraction, readings: list[tuple[int, Fraction]]) -> None:
    """Exact fractions: a forward model p(z | occ), p(z | free) for each reading, and its inverse model by Bayes."""
    occupied, free = prior, 1 - prior
    total = float(log_odds(float(prior)))
    for reading, p_one in readings:
        p_occ, p_free = (p_one, Fraction(1, 3)) if reading else (1 - p_one, Fraction(2, 3))
        occupied, free = occupied * p_occ, free * p_free
        inverse = prior * p_occ / (prior * p_occ + (1 - prior) * p_free)
        total += float(log_odds(float(inverse))) - float(log_odds(float(prior)))
    assert float(probability_of_log_odds(total)) == pytest.approx(float(occupied / (occupied + free)), rel=1e-9)


def test_theorem_2_over_all_maps() -> None:
    """Four cells, sixteen maps weighed by brute force: the marginals are those of the sums."""
    rng = np.random.default_rng(1)
    readings = [(int(rng.integers(4)), bool(rng.integers(2))) for _ in range(15)]
    weights = {}
    for cells in itertools.product((False, True), repeat=4):
        weights[cells] = math.prod(0.7 if cells[k] == seen else 0.3 for k, seen in readings)
    sums = [sum(SEVENTY if seen else -SEVENTY for k, seen in readings if k == cell) for cell in range(4)]
    for cell in range(4):
        marginal = sum(w for cells, w in weights.items() if cells[cell]) / sum(weights.values())
        assert float(probability_of_log_odds(sums[cell])) == pytest.approx(marginal, rel=1e-12)


def test_exercise_2_three_hits_and_a_miss_then_six_net_hits() -> None:
    """A wall 1.5 cells ahead, seen three times, then seen through: p = 0.845; six net hits pass 0.99, five do not."""
    grid = OccupancyGrid(np.zeros((1, 4)))
    wall, through = Scan([1.5], [0.0], 9.0), Scan([2.5], [0.0], 9.0)
    for scan in (wall, wall, wall, through):
        grid.integrate(scan, [0.5, 0.5, 0.0])
    assert grid.log_odds[0, 2] == pytest.approx(2 * SEVENTY)
    assert grid.probabilities[0, 2] == pytest.approx(0.845, abs=5e-4)
    assert float(probability_of_log_odds(5 * SEVENTY)) < 0.99 < float(probability_of_log_odds(6 * SEVENTY))


def test_log_odds_stay_within_the_bound_and_can_come_back() -> None:
    grid = OccupancyGrid(np.zeros((1, 6)))
    for _ in range(100):
        grid.integrate(Scan([3.2], [0.0], 9.0), [0.5, 0.5, 0.0])
    np.testing.assert_allclose(grid.log_odds[0], [-5, -5, -5, 5, 0, 0])
    for _ in range(6):
        grid.integrate(Scan([9.0], [0.0], 9.0), [0.5, 0.5, 0.0])
    assert grid.probabilities[0, 3] < 0.5


def marched(start: Any, end: Any) -> set[tuple[int, int]]:
    """The cells under points close together on the segment."""
    points = np.linspace(start, end, 8_001)
    return set(map(tuple, np.floor(points).astype(int).tolist()))


point = st.tuples(st.floats(-6, 6), st.floats(-6, 6))
#: The march rounds its points: within this distance of an edge, it may be on either side.
EDGE = 1e-9


@settings(deadline=None, max_examples=40)
@given(point, point)
@example((1.0, 7.5e-164), (0.0, -1.0))
@example((0.0, -5e-136), (1.0, 0.0))
@example((6.0, 0.0), (5.999999999999999, 2.0))
def test_crossed_cells_are_those_under_the_segment(start: Any, end: Any) -> None:
    cells = crossed_cells([start], [end])
    found = list(zip(cells.x.tolist(), cells.y.tolist(), strict=True))
    assert len(found) == len(set(found))
    assert {tuple(np.floor(start).astype(int)), tuple(np.floor(end).astype(int))} <= set(found)
    for x, y in set(found) ^ marched(start, end):
        assert grazes(np.array([x, y]), np.array(start), np.array(end))


def grazes(cell: Any, start: Any, end: Any) -> bool:
    """Whether the segment is inside the cell, a rounding away from its edges, over a few steps of the march at most."""
    low, high = 0.0, 1.0
    for axis in range(2):
        d = end[axis] - start[axis]
        if d == 0.0:
            continue
        near, far = sorted(((cell[axis] + EDGE - start[axis]) / d, (cell[axis] + 1 - EDGE - start[axis]) / d))
        low, high = max(low, near), min(high, far)
    return bool((high - low) * np.hypot(*(end - start)) < 5e-3)


def test_many_segments_are_as_each_alone_and_corners_are_crossed_once() -> None:
    rng = np.random.default_rng(2)
    starts, ends = rng.uniform(-9, 9, (2, 50, 2))
    together = crossed_cells(starts, ends)
    for k in range(50):
        alone, mine = crossed_cells(starts[k : k + 1], ends[k : k + 1]), together.segment == k
        assert sorted(zip(alone.x, alone.y, strict=True)) == sorted(
            zip(together.x[mine], together.y[mine], strict=True)
        )
    for sx, sy in itertools.product((1, -1), repeat=2):
        diagonal = crossed_cells([(0.5, 0.5)], [(0.5 + 3 * sx, 0.5 + 3 * sy)])
        found = list(zip(diagonal.x.tolist(), diagonal.y.tolist(), strict=True))
        wanted = {(sx * k, sy * k) for k in range(4)} | {(sx * k, sy * (k + 1)) for k in range(3)}
        assert len(found) == 7
        assert set(found) == wanted


def test_a_scan_marks_what_it_crosses_and_what_stops_it() -> None:
    grid = OccupancyGrid(np.zeros((3, 5)), 0.5, np.array([1.0, 2.0, 0.0]))
    grid.integrate(Scan([1.1, 9.0], [0.0, np.pi / 2], 9.0), [1.25, 2.25, 0.0])
    wanted = np.zeros((3, 5))
    wanted[0, :2] = -SEVENTY
    wanted[0, 0] -= SEVENTY
    wanted[0, 2] = SEVENTY
    wanted[1:, 0] = -SEVENTY
    np.testing.assert_allclose(grid.log_odds, wanted)


NO_MEASUREMENTS = [math.nan, -math.inf, 0.0, -1.0, 0.05]


@pytest.mark.parametrize("reading", NO_MEASUREMENTS)
@pytest.mark.parametrize("once", [True, False])
def test_a_beam_that_was_not_measured_clears_no_wall(reading: float, once: bool) -> None:
    """What a mapped wall is, and what lies behind it, stays as it was; a beam beside it still counts."""
    grid = OccupancyGrid(np.zeros((3, 60)), 0.1, np.array([0, -0.15, 0.0]), InverseSensorModel(once_a_scan=once))
    for _ in range(5):
        grid.integrate(Scan.from_sensor([2.0], [0.0], 5.0, 0.1), [0.05, 0, 0])
    before = grid.log_odds.copy()
    for _ in range(10):
        grid.integrate(Scan.from_sensor([reading], [0.0], 5.0, 0.1), [0.05, 0, 0])
    np.testing.assert_array_equal(grid.log_odds, before)
    grid.integrate(Scan.from_sensor([reading, math.inf], [0.0, 0.0], 5.0, 0.1), [0.05, 0, 0])
    assert grid.log_odds[1, 20] < before[1, 20]
    assert grid.log_odds[1, 40] < 0.0


@pytest.mark.parametrize("once", [True, False])
@pytest.mark.parametrize("reading", [0.02, 0.04])
def test_no_reading_marks_the_cell_of_the_lidar_itself(once: bool, reading: float) -> None:
    grid = OccupancyGrid(np.zeros((3, 5)), 0.1, model=InverseSensorModel(once_a_scan=once))
    for _ in range(10):
        grid.integrate(Scan.full_turn([reading, 2.0, reading, reading], 5.0), [0.25, 0.15, 0.3])
    assert grid.probabilities[1, 2] < 0.05


@settings(deadline=None, max_examples=30)
@given(seed=seeds)
def test_the_cell_of_the_lidar_never_looks_occupied(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = OccupancyGrid(np.zeros((12, 12)), 0.1)
    pose = [*rng.uniform(0.1, 1.1, 2), rng.uniform(-3, 3)]
    readings = np.where(rng.random(20) < 0.3, rng.uniform(0, 0.2, 20), rng.uniform(0, 2.0, 20))
    grid.integrate(Scan.full_turn(readings, 2.0), pose)
    assert grid.log_odds[int(pose[1] / 0.1), int(pose[0] / 0.1)] <= 0.0


@pytest.mark.parametrize("far", [1e6, -3e7, 1e200])
def test_a_pose_gone_astray_makes_no_giant_map(far: float) -> None:
    with pytest.raises(OccupancyError, match="see pose 1") as caught:
        build_map([Scan.full_turn([1.0, 2.0], 5.0)] * 4, [(0, 0, 0), (far, far, 0), (1, 0, 0), (2, 0, 0)], 0.05)
    assert caught.value.argument == "poses"


@pytest.mark.parametrize("resolution", [1e-5, 1e-9, 1e-200, 5e-324])
@pytest.mark.parametrize("count", [1, 2, 40])
def test_an_absurd_resolution_makes_no_giant_map_and_blames_no_pose(resolution: float, count: int) -> None:
    poses = np.column_stack([np.linspace(0.0, 30.0, count), np.zeros((count, 2))])
    with pytest.raises(OccupancyError, match=r"take .* m or more") as caught:
        build_map([Scan.full_turn([1.0, 2.0, 3.0], 5.0)] * count, poses, resolution)
    assert caught.value.argument == "resolution"
    least = float(str(caught.value).split("take ")[1].split(" m")[0])
    height, width = build_map([Scan.full_turn([1.0, 2.0, 3.0], 5.0)] * count, poses, 20 * least).log_odds.shape
    assert 400 * height * width == pytest.approx(50_000_000, rel=0.2)


def test_a_map_of_scans_with_gaps_is_that_of_their_measured_beams() -> None:
    rng = np.random.default_rng(5)
    angles, poses = full_turn_angles(60), rng.uniform(-1, 1, (4, 3))
    readings = np.where(rng.random((4, 60)) < 0.3, math.nan, rng.uniform(0.5, 7, (4, 60)))
    scans = [Scan.from_sensor(row, angles, 6.0) for row in readings]
    alone = [Scan.from_sensor(row[~np.isnan(row)], angles[~np.isnan(row)], 6.0) for row in readings]
    np.testing.assert_array_equal(build_map(scans, poses, 0.1).log_odds, build_map(alone, poses, 0.1).log_odds)


def test_one_vote_a_scan_and_stopping_wins() -> None:
    scan = Scan([1.2, 1.2, 2.4], [0.0, 0.01, 0.0], 9.0)
    grid = OccupancyGrid(np.zeros((1, 4)), model=InverseSensorModel(once_a_scan=True))
    grid.integrate(scan, [0.5, 0.5, 0.0])
    np.testing.assert_allclose(grid.log_odds[0], [-SEVENTY, SEVENTY, SEVENTY, 0])


@settings(deadline=None, max_examples=20)
@given(seed=seeds, heading=st.floats(-3, 3))
def test_a_turned_frame_gives_the_same_map(seed: int, heading: float) -> None:
    rng = np.random.default_rng(seed)
    scan = Scan.full_turn(rng.uniform(0.5, 4, 40), 5.0)
    pose = np.array([4.3, 3.7, 0.2])
    plain = OccupancyGrid(np.zeros((10, 10)))
    plain.integrate(scan, pose)
    corner = GridMap.from_free(np.ones((10, 10), bool), 0.1, (3.0, -2.0, heading))
    turned = OccupancyGrid(np.zeros((10, 10)), 0.1, corner.T_world_map)
    turned.integrate(Scan(scan.ranges * 0.1, scan.angles, 0.5), corner.poses_to_world(pose))
    assert np.mean(np.abs(turned.log_odds - plain.log_odds) > 1e-9) < 0.05


def test_many_scans_show_the_room() -> None:
    """Cells seen are judged free inside and occupied on the walls."""
    rng = np.random.default_rng(4)
    free = np.zeros((40, 50), bool)
    free[1:-1, 1:-1] = True
    free[10:20, 15:18] = False
    grid = OccupancyGrid(np.zeros(free.shape))
    angles = full_turn_angles(180)
    for _ in range(40):
        pose = np.array([rng.uniform(3, 12), rng.uniform(3, 37), rng.uniform(-3, 3)])
        ranges = cast_rays(free, np.tile(pose[:2], (180, 1)), angles + pose[2], 60.0)
        grid.integrate(Scan(ranges, angles, 60.0), pose)
    found = grid.to_grid_map()
    assert np.mean(free[found.free]) > 0.995
    assert np.mean(~free[found.occupied]) > 0.97
    assert found.free[free].mean() > 0.8


def test_the_map_is_as_large_as_what_was_seen() -> None:
    scans = [Scan.full_turn([2.0, 3.0, 4.0, 9.0], 9.0)] * 2
    grid = build_map(scans, [(0, 0, 0), (1, 0, 0)], 0.1, margin=0.5)
    low = grid.T_world_map[:2]
    high = low + 0.1 * np.array(grid.log_odds.shape[::-1])
    assert np.all(low <= [-4.5, 0 - 0.5])
    assert np.all(high >= [3.5, 3.5])
    assert np.all(high - low <= [9.3, 4.3])
    assert grid.to_grid_map().occupied.sum() == 4  # of six ends, two were seen through by the other scan


LINE = "FLASER 4 1.0 2.5 81.83 3 0.1 0.2 0.3 0.4 0.5 0.6 12.5 pippo 12.5"


def test_flaser_lines_are_read() -> None:
    log = parse_flaser(f"# a log\nODOM 0 0 0 0 0 0 1 pippo 1\n{LINE}\nNEFF 15\n", 50.0)
    assert len(log) == 1
    np.testing.assert_array_equal(log.scans[0].ranges, [1.0, 2.5, 50.0, 3.0])
    np.testing.assert_allclose(log.scans[0].angles, np.deg2rad([-90, -45, 0, 45]))
    np.testing.assert_array_equal(log.T_world_laser, [[0.1, 0.2, 0.3]])
    np.testing.assert_array_equal(log.T_odom_robot, [[0.4, 0.5, 0.6]])
    assert log.times.tolist() == [12.5]
    np.testing.assert_allclose(np.rad2deg(beam_angles(181)), np.arange(-90, 91), atol=1e-9)


@pytest.mark.parametrize(
    "line", ["FLASER x 1", "FLASER 4 1 2 3", LINE.replace("2.5", "two"), LINE.replace("0.3", "nan"), "FLASER 0"]
)
def test_a_broken_log_is_refused_with_its_line(line: str) -> None:
    with pytest.raises(LogError, match="line 2"):
        parse_flaser(f"# a log\n{line}", 50.0)


def test_the_intel_log_becomes_a_sharp_map(dataset: Callable[[str], bytes]) -> None:
    """910 scans with poses corrected by FastSLAM: walls are thin, and most cells are sure."""
    log = parse_flaser(dataset("laser/intel.gfs.log").decode(), 40.0)
    assert len(log) == 910
    steps = range(0, len(log), 5)
    grid = build_map([log.scans[k] for k in steps], log.T_world_laser[::5], 0.1)
    found = grid.to_grid_map(0.8)
    assert 20 < found.shape[0] * 0.1 < 60
    assert found.free.sum() > 5 * found.occupied.sum()
    ends = [crossing for k in steps for crossing in _ends(log.scans[k], log.T_world_laser[k])]
    cells = np.floor(found.to_cells(np.array(ends))).astype(int)
    assert np.mean(distances_to_cells(grid.log_odds > 0)[cells[:, 1], cells[:, 0]] < 2) > 0.8


def _ends(scan: Scan, pose: Any) -> Any:
    near = scan.hit_mask & (scan.ranges < 15.0)
    angles = scan.angles[near] + pose[2]
    return pose[:2] + (scan.ranges[near] + 1e-6)[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("p", lambda: log_odds([0.5, 1.0])),
        ("hit", lambda: InverseSensorModel(hit=-1.0)),
        ("miss", lambda: InverseSensorModel(miss=np.nan)),
        ("clamp", lambda: InverseSensorModel(clamp=0.0)),
        ("log_odds", lambda: OccupancyGrid(np.zeros(3))),
        ("log_odds", lambda: OccupancyGrid(np.full((2, 2), np.nan))),
        ("resolution", lambda: OccupancyGrid(np.zeros((2, 2)), 0.0)),
        ("T_world_map", lambda: OccupancyGrid(np.zeros((2, 2)), 1.0, np.zeros(2))),
        ("T_world_robot", lambda: OccupancyGrid(np.zeros((2, 2))).integrate(Scan([1.0], [0.0], 2.0), [0, np.nan, 0])),
        ("scan", lambda: OccupancyGrid(np.zeros((2, 2))).integrate(Scan([], [], 2.0), [0, 0, 0])),
        ("threshold", lambda: OccupancyGrid(np.zeros((2, 2))).to_grid_map(0.4)),
        ("poses", lambda: build_map([Scan([1.0], [0.0], 2.0)], np.zeros((2, 3)), 0.1)),
        ("scans", lambda: build_map([], np.zeros((0, 3)), 0.1)),
        ("resolution", lambda: build_map([Scan([1.0], [0.0], 2.0)], np.zeros((1, 3)), 0.0)),
        ("margin", lambda: build_map([Scan([1.0], [0.0], 2.0)], np.zeros((1, 3)), 0.1, margin=-1.0)),
        ("starts", lambda: crossed_cells([(0, np.nan)], [(0, 0)])),
        ("ends", lambda: crossed_cells([(0, 0)], [(0, 0), (1, 1)])),
    ],
)
def test_what_makes_no_map_is_refused_by_name(argument: str, call: Any) -> None:
    with pytest.raises(InvalidArgumentError) as caught:
        call()
    assert caught.value.argument == argument
    assert isinstance(caught.value, OccupancyError) or argument in ("starts", "ends")
