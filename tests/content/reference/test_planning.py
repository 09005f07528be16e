"""Planning: ways as short as SciPy's and as the published optima; a robot that arrives and touches nothing."""

from __future__ import annotations

import os
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from scipy import sparse
from scipy.integrate import solve_ivp
from scipy.sparse import csgraph

from reference.errors import InvalidArgumentError
from reference.planning import (
    DynamicWindow,
    PlanningError,
    RobotLimits,
    SearchGrid,
    UnreachableError,
    inflate,
    navigate,
    parse_map,
    parse_scenarios,
)
from reference.planning.dynamic_window import move_along_arcs, predict_drive
from reference.world.grid_map import GridMap
from tests.support.quick import one_in, some

Floats = NDArray[np.float64]
seeds = st.integers(0, 2**32 - 1)
MOVES = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0)]


def random_world(seed: int) -> tuple[Any, Any]:
    rng = np.random.default_rng(seed)
    free = rng.random((int(rng.integers(2, 14)), int(rng.integers(2, 14)))) > 0.3
    free[0, 0] = True
    return free, np.where(rng.random(free.shape) < 0.5, rng.uniform(0, 4, free.shape), 0.0)


def by_scipy(free: Any, costs: Any, corner_cutting: bool) -> Floats:
    """Costs of the cheapest ways from cell (0, 0), on the graph of all moves written out."""
    height, width = free.shape
    graph = sparse.lil_array((free.size, free.size))
    for y, x in zip(*np.nonzero(free), strict=True):
        for dy, dx in MOVES:
            v, u = y + dy, x + dx
            if not (0 <= v < height and 0 <= u < width and free[v, u]):
                continue
            if not corner_cutting and not (free[y, u] and free[v, x]):
                continue
            graph[y * width + x, v * width + u] = np.hypot(dy, dx) * (1 + (costs[y, x] + costs[v, u]) / 2)
    return np.asarray(csgraph.dijkstra(graph.tocsr(), indices=0)).reshape(free.shape)


@settings(deadline=None, max_examples=40)
@given(seed=seeds, corner_cutting=st.booleans(), priced=st.booleans())
def test_ways_are_as_cheap_as_scipys(seed: int, corner_cutting: bool, priced: bool) -> None:
    free, costs = random_world(seed)
    grid = SearchGrid(free, costs if priced else None, corner_cutting=corner_cutting)
    wanted = by_scipy(free, costs if priced else 0 * costs, corner_cutting)
    np.testing.assert_allclose(grid.costs_from((0, 0)), wanted, rtol=1e-9)
    for y, x in zip(*np.nonzero(free), strict=True):
        goal = (int(y), int(x))
        if not np.isfinite(wanted[goal]):
            with pytest.raises(UnreachableError):
                grid.astar((0, 0), goal)
            continue
        found, slow = grid.astar((0, 0), goal), grid.dijkstra((0, 0), goal)
        assert found.cost == pytest.approx(wanted[goal], rel=1e-9)
        assert slow.cost == pytest.approx(wanted[goal], rel=1e-9)
        assert_way(found.cells, free, goal, corner_cutting)
        if not priced:
            assert found.length_in_cells == pytest.approx(found.cost)
            np.testing.assert_array_equal(found.cell_centres[-1], [x + 0.5, y + 0.5])


def assert_way(cells: Any, free: Any, goal: tuple[int, int], corner_cutting: bool) -> None:
    assert tuple(cells[0]) == (0, 0)
    assert tuple(cells[-1]) == goal
    assert free[cells[:, 0], cells[:, 1]].all()
    for (y, x), (v, u) in pairwise(cells.tolist()):
        assert max(abs(v - y), abs(u - x)) == 1
        assert corner_cutting or (free[y, u] and free[v, x])


def test_the_heuristic_spares_cells_and_corners_make_a_difference() -> None:
    free = np.ones((30, 30), bool)
    grid = SearchGrid(free)
    assert grid.astar((3, 3), (3, 25)).expanded_count < grid.dijkstra((3, 3), (3, 25)).expanded_count / 5
    corner = np.array([[1, 0], [1, 1]], bool)
    assert SearchGrid(corner).astar((0, 0), (1, 1)).cost == 2.0
    assert SearchGrid(corner, corner_cutting=True).astar((0, 0), (1, 1)).cost == pytest.approx(np.sqrt(2))


@settings(deadline=None, max_examples=40)
@given(seed=seeds, weight=st.floats(1.0, 6.0))
def test_a_weighted_way_costs_at_most_the_weight_times_the_least(seed: int, weight: float) -> None:
    free, costs = random_world(seed)
    grid = SearchGrid(free, costs)
    least = grid.costs_from((0, 0))
    for y, x in some(np.argwhere(free & np.isfinite(least)).tolist()):
        found = grid.astar((0, 0), (y, x), weight=weight)
        assert least[y, x] - 1e-9 <= found.cost <= weight * least[y, x] + 1e-9
        assert_way(found.cells, free, (y, x), False)


def test_cells_come_in_the_order_in_which_they_were_looked_at() -> None:
    free = np.ones((9, 9), bool)
    found = SearchGrid(free).dijkstra((4, 4), (0, 0))
    away = SearchGrid(free).costs_from((4, 4))[tuple(found.order.T)]
    assert found.order[0].tolist() == [4, 4]
    assert found.order[-1].tolist() == [0, 0]
    assert np.all(np.diff(away) >= 0)
    assert len(np.unique(found.order, axis=0)) == found.expanded_count
    free[4] = False
    with pytest.raises(UnreachableError) as caught:
        SearchGrid(free).astar((0, 0), (8, 8))
    assert len(caught.value.order) == 36


@pytest.mark.parametrize("weight", [0.9, np.nan, np.inf])
def test_a_weight_that_is_none_is_refused(weight: float) -> None:
    with pytest.raises(PlanningError, match="weight"):
        SearchGrid(np.ones((3, 3), bool)).astar((0, 0), (2, 2), weight=weight)


def test_inflation_closes_what_is_too_near_and_keeps_away_from_walls() -> None:
    free = np.zeros((13, 30), bool)
    free[1:-1, 1:-1] = True
    swollen = inflate(free, 2.0)
    assert not swollen.free[3:10, 2].any()
    assert swollen.free[3:10, 3:-3].all()
    assert np.all(np.diff(swollen.costs[3:7, 15]) < 0)
    assert np.all(swollen.costs[~swollen.free] == 0)
    way = SearchGrid(swollen.free, swollen.costs).astar((3, 4), (3, 25)).cells
    assert way[:, 0].max() == 6
    assert SearchGrid(swollen.free).astar((3, 4), (3, 25)).cells[:, 0].max() == 3


def scenarios(dataset: Callable[[str], bytes]) -> tuple[SearchGrid, Any]:
    grid = SearchGrid(parse_map(dataset("astar/AR0011SR.map").decode()))
    return grid, parse_scenarios(dataset("astar/AR0011SR.map.scen").decode())


def test_published_optima_of_the_moving_ai_map(dataset: Callable[[str], bytes]) -> None:
    """One scenario of each length; all 1280 with BALISE_ALL_SCENARIOS=1."""
    grid, cases = scenarios(dataset)
    assert len(cases) == 1280
    chosen = cases if os.environ.get("BALISE_ALL_SCENARIOS") else cases[5:600:45]
    for case in chosen:
        assert grid.astar(case.start, case.goal).cost == pytest.approx(case.optimum, abs=0.005)


def test_the_optima_do_not_hold_with_corners_cut(dataset: Callable[[str], bytes]) -> None:
    _, cases = scenarios(dataset)
    cutting = SearchGrid(parse_map(dataset("astar/AR0011SR.map").decode()), corner_cutting=True)
    assert any(cutting.astar(c.start, c.goal).cost < c.optimum - 0.1 for c in cases[:6])


MAP = "type octile\nheight 2\nwidth 3\nmap\n.@G\nTS.\n"


def test_maps_and_scenarios_are_read() -> None:
    np.testing.assert_array_equal(parse_map(MAP), [[True, False, True], [False, True, True]])
    (case,) = parse_scenarios("version 1\n3\tm.map\t3\t2\t0\t1\t2\t0\t2.41421\n\n")
    assert (case.start, case.goal, case.optimum) == ((1, 0), (0, 2), 2.41421)


# Seeds of scenes in which a way is wide enough for the robot.
OPEN_SCENES = [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 3, 5))]


def scene(seed: int) -> GridMap:
    """A hall of 10 x 8 m with a dozen blocks, free around two opposite corners."""
    rng = np.random.default_rng(seed)
    free = np.zeros((80, 100), bool)
    free[1:-1, 1:-1] = True
    for _ in range(12):
        y, x, h, w = *rng.integers((8, 8), (66, 86)), *rng.integers(3, 14, 2)
        free[y : y + h, x : x + w] = False
    free[1:14, 1:14] = free[-14:-1, -14:-1] = True
    return GridMap.from_free(free, 0.1, (-2.0, 1.0, 0.3))


@pytest.mark.parametrize("seed", OPEN_SCENES)
def test_the_robot_arrives_and_touches_nothing(seed: int) -> None:
    """Walls are looked for along the way as driven, with exact arcs, on all points of the rim."""
    world, limits = scene(seed), RobotLimits()
    start, goal = world.poses_to_world([7.0, 7.0, np.pi]), world.to_world([93.0, 73.0])
    found = navigate(world, start, goal, limits)
    assert found.has_reached_goal
    assert found.clearance > 0
    assert np.hypot(*(found.poses[-1, :2] - goal)) <= 0.15
    rim = np.linspace(0, 2 * np.pi, 48)
    for pose, speed in zip(found.poses, found.speeds, strict=False):
        passed = np.concatenate([move_along_arcs(pose[None], speed[None], t) for t in np.linspace(0, limits.period, 6)])
        ring = passed[:, None, :2] + limits.radius * np.column_stack([np.cos(rim), np.sin(rim)])
        assert world.is_free(ring).all()
    steps = np.abs(np.diff(np.vstack([np.zeros((1, 2)), found.speeds]), axis=0))
    assert np.all(steps <= np.array([limits.max_dv, limits.max_dw]) * limits.period + 1e-9)
    assert np.all(found.speeds[:, 0] >= 0)
    assert np.all(np.abs(found.speeds) <= [limits.max_v + 1e-9, limits.max_w + 1e-9])


HALL = np.zeros((60, 60), bool)
HALL[1:-1, 1:-1] = True


@pytest.mark.parametrize("heading", one_in(3, range(0, 360, 45)))
def test_a_goal_right_behind_is_reached(heading: int) -> None:
    """Over one horizon no turn is worth its while: the octile cost ahead of the robot rises before it falls."""
    world, back = GridMap.from_free(HALL, 0.1), np.radians(heading + 180.0)
    goal = [3.0 + 2.0 * np.cos(back), 3.0 + 2.0 * np.sin(back)]
    for off in (0.0, 5.0, -10.0):
        found = navigate(world, [3.0, 3.0, np.radians(heading + off)], goal, max_time=20.0)
        assert found.has_reached_goal
        assert found.clearance > 0


@pytest.mark.slow
@pytest.mark.parametrize("distance", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("bearing", range(0, 360, 15))
def test_from_any_heading_a_goal_at_any_bearing_is_reached(bearing: int, distance: float) -> None:
    world, towards = GridMap.from_free(np.pad(np.ones((118, 118), bool), 1), 0.1), np.radians(bearing)
    goal = [6.0 + distance * np.cos(towards), 6.0 + distance * np.sin(towards)]
    for heading in range(0, 360, 15):
        assert navigate(world, [6.0, 6.0, np.radians(heading)], goal, max_time=30.0).has_reached_goal


def some_journey(seed: int) -> tuple[GridMap, np.ndarray, np.ndarray]:
    """A scene with blocks, a start with any heading and a goal, both where the robot can stand, joined by a way."""
    rng, world = np.random.default_rng(seed), scene(seed % 50)
    cells = np.argwhere(inflate(world.free, 2.0 + np.sqrt(2.0)).free)
    while True:
        (ay, ax), (by, bx) = rng.choice(cells, 2, replace=False)
        goal = np.asarray(world.to_world([bx + rng.random(), by + rng.random()]))
        if np.isfinite(DynamicWindow.from_goal(world, goal, RobotLimits()).ways[ay, ax]):
            start = world.poses_to_world([ax + rng.random(), ay + rng.random(), rng.uniform(-3.14, 3.14)])
            return world, np.asarray(start), goal


@pytest.mark.parametrize("seed", one_in(30, range(60)))
@pytest.mark.parametrize("patience", [1.0, 1e-6])
def test_among_obstacles_a_goal_to_which_a_way_leads_is_reached(seed: int, patience: float) -> None:
    """By the window and its rule against stalls; and by that rule alone, all the way."""
    world, start, goal = some_journey(seed)
    found = navigate(world, start, goal, RobotLimits(patience=patience), max_time=400.0)
    assert found.has_reached_goal
    assert found.clearance > 0
    assert np.all(found.speeds[:, 0] >= 0)
    steps = np.abs(np.diff(np.vstack([np.zeros((1, 2)), found.speeds]), axis=0))
    limits = RobotLimits()
    assert np.all(steps <= np.array([limits.max_dv, limits.max_dw]) * limits.period + 1e-9)
    assert np.all(np.abs(found.speeds) <= [limits.max_v + 1e-9, limits.max_w + 1e-9])


@settings(deadline=None, max_examples=6)
@given(seed=seeds)
def test_from_rest_no_wish_leads_into_a_wall(seed: int) -> None:
    """The safe choices stay safe when something else than the score picks among them: here, at random."""
    rng = np.random.default_rng(seed)
    world, limits = scene(seed % 1000), RobotLimits(max_v=1.5, max_dv=0.5)
    window = DynamicWindow.from_goal(world, world.to_world([93.0, 73.0]), limits)
    object.__setattr__(window, "remaining", rng.uniform(0, 9, window.remaining.shape))
    pose, speed = np.array(world.poses_to_world([7.0, 7.0, 0.0])), np.zeros(2)
    for _ in range(40):
        speed = window.choose_speed(pose, speed)
        passed = predict_drive(pose, speed[None], limits, brake=False, duration=limits.period)[0]
        assert window.clearance(passed).min() > limits.radius
        pose = passed[-1]


@given(st.floats(-2, 2), st.floats(-3, 3), st.floats(-3, 3))
@settings(deadline=None, max_examples=30)
def test_an_arc_is_the_integral_of_the_speeds(v: float, w: float, heading: float) -> None:
    peer = solve_ivp(
        lambda _, s: [v * np.cos(s[2]), v * np.sin(s[2]), w], (0, 0.7), [1.0, 2.0, heading], rtol=1e-10, atol=1e-12
    )
    found = move_along_arcs(np.array([[1.0, 2.0, heading]]), np.array([[v, w]]), 0.7)[0]
    np.testing.assert_allclose(found[:2], peer.y[:2, -1], atol=1e-8)
    assert np.cos(found[2] - peer.y[2, -1]) == pytest.approx(1.0)


def test_a_goal_behind_a_closed_wall_is_not_reached() -> None:
    free = np.ones((40, 40), bool)
    free[:, 20] = False
    found = navigate(GridMap.from_free(free, 0.1), [1.0, 2.0, 0.0], [3.2, 2.0], max_time=5.0)
    assert not found.has_reached_goal
    assert found.clearance > 0


ROOM = GridMap.from_free(np.ones((30, 30), bool), 0.1)


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("free", lambda: SearchGrid([True])),
        ("costs", lambda: SearchGrid([[True]], [[-1.0]])),
        ("costs", lambda: SearchGrid([[True]], [[np.nan]])),
        ("start", lambda: SearchGrid([[False, True]]).astar((0, 0), (0, 1))),
        ("goal", lambda: SearchGrid([[True, True]]).astar((0, 0), (0, 2))),
        ("goal", lambda: SearchGrid([[True, False, True]]).dijkstra((0, 0), (0, 2))),
        ("radius", lambda: inflate([[True]], -1.0)),
        ("weight", lambda: inflate([[True]], 1.0, weight=np.inf)),
        ("free", lambda: inflate([True], 1.0)),
        ("text", lambda: parse_map("type octile\nheight two")),
        ("text", lambda: parse_map(MAP.replace("TS.", "TS"))),
        ("text", lambda: parse_scenarios("version 1\n1 2 3")),
        ("max_v", lambda: RobotLimits(max_v=0.0)),
        ("samples", lambda: RobotLimits(samples=1)),
        ("goal", lambda: navigate(ROOM, [1.5, 1.5, 0.0], [0.0, 0.0])),
        ("goal", lambda: navigate(ROOM, [1.5, 1.5, 0.0], [np.nan, 0.0])),
        ("start", lambda: navigate(ROOM, [0.0, 1.5, 0.0], [1.5, 1.5])),
        ("start", lambda: navigate(ROOM, [1.5, 1.5], [1.5, 1.5])),
    ],
)
def test_what_cannot_be_planned_is_refused_by_name(argument: str, call: Any) -> None:
    with pytest.raises(InvalidArgumentError) as caught:
        call()
    assert isinstance(caught.value, PlanningError)
    assert caught.value.argument == argument
