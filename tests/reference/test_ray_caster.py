"""The fast ray caster: against the walk from cell to cell, a naive one, and rectangles counted by hand."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.world.empty_rectangles import empty_squares, stretched_widths
from reference.world.ray_caster import RayCaster
from reference.world.raycast import RaycastError, cast_rays, cast_scans

seeds = st.integers(0, 2**32 - 1)


def naive(free: np.ndarray, x: float, y: float, angle: float, max_range: float) -> float:
    """From cell to cell, each line's time computed afresh from the line itself."""
    column, row = math.floor(x), math.floor(y)
    dx, dy = math.cos(angle), math.sin(angle)
    time = 0.0
    while 0 <= row < free.shape[0] and 0 <= column < free.shape[1] and free[row, column]:
        to_x = (column + (dx > 0) - x) / dx if dx else math.inf
        to_y = (row + (dy > 0) - y) / dy if dy else math.inf
        time = min(to_x, to_y)
        if time >= max_range:
            return max_range
        if to_x < to_y:
            column += 1 if dx > 0 else -1
        else:
            row += 1 if dy > 0 else -1
    return time


@settings(deadline=None)
@given(seeds, st.floats(0.0, 0.6), st.sampled_from([3.0, 11.0, 60.0]))
def test_distances_are_those_of_the_walks(seed: int, walls: float, max_range: float) -> None:
    rng = np.random.default_rng(seed)
    free = rng.random((rng.integers(1, 25), rng.integers(1, 25))) >= walls
    origins = rng.uniform(-1.0, 1.0 + np.array(free.shape[::-1]), (60, 2))
    angles = rng.uniform(-math.pi, math.pi, 60)
    found = RayCaster.of(free).cast(origins, angles, max_range)
    np.testing.assert_allclose(found, cast_rays(free, origins, angles, max_range), atol=1e-9)
    walked = [naive(free, x, y, angle, max_range) for (x, y), angle in zip(origins, angles, strict=True)]
    np.testing.assert_allclose(found, walked, atol=1e-9)


def test_fifteen_thousand_rays_in_rooms_of_two_hundred_cells() -> None:
    rng = np.random.default_rng(2)
    free = np.ones((200, 200), dtype=bool)
    free[::25], free[:, ::25] = False, False
    free[np.arange(200) % 25 > 18] = True
    free[:, np.arange(200) % 25 > 18] = True
    poses = np.column_stack([rng.uniform(0, 200, (500, 2)), rng.uniform(-4, 4, 500)])
    found = RayCaster.of(free).scans(poses, 2 * np.pi * np.arange(30) / 30, 300.0)
    np.testing.assert_allclose(found, cast_scans(free, poses, 30, 300.0), atol=1e-9)


@pytest.mark.parametrize("angle", [k * math.pi / 2 for k in range(-3, 5)] + [0.0, -0.0])
def test_along_the_axes_even_from_the_lines_themselves(angle: float) -> None:
    """From corners and sides of cells too, where rays run along a line: as the walk has it."""
    rng = np.random.default_rng(9)
    free = rng.random((9, 12)) > 0.2
    origins = np.stack(np.meshgrid(np.arange(0, 12, 0.5), np.arange(0, 9, 0.5)), axis=-1).reshape(-1, 2)
    angles = np.full(len(origins), angle)
    expected = cast_rays(free, origins, angles, 50.0)
    np.testing.assert_allclose(RayCaster.of(free).cast(origins, angles, 50.0), expected, rtol=1e-14, atol=1e-300)


def test_through_the_corners_of_cells_a_ray_enters_one_of_the_neighbours() -> None:
    """Diagonals from the centres of cells: rounding may choose the side, but no ray gets past a closed corner."""
    free = np.array([[1, 1, 0, 1], [1, 1, 1, 1], [1, 1, 1, 1]], dtype=bool)
    caster = RayCaster.of(free)
    for x, y, angle, possible in (
        (0.5, 1.5, -math.pi / 4, (1.5, 0.5)),
        (0.5, 0.5, math.pi / 4, (2.5,)),
        (3.5, 1.5, -3 * math.pi / 4, (0.5,)),
    ):
        found = caster.cast([[x, y]], [angle], 20.0)[0] / math.sqrt(2.0)
        assert min(abs(found - distance) for distance in possible) < 1e-12


@pytest.mark.parametrize("quarter", range(4))
def test_no_ray_slips_between_two_walls_that_touch_at_a_corner(quarter: int) -> None:
    """A wall drawn along a diagonal holds rays from the centres of cells, which aim at its very corners."""
    free = np.ones((30, 30), dtype=bool)
    free[np.arange(30), np.arange(29, -1, -1)] = False
    inside = np.argwhere(free & (np.add.outer(np.arange(30), np.arange(30)) < 29))
    caster, origins = RayCaster.of(np.rot90(free, quarter)), inside[:, ::-1] + 0.5
    angle = math.pi / 4
    for _ in range(quarter):
        origins, angle = np.column_stack([origins[:, 1], 30.0 - origins[:, 0]]), angle - math.pi / 2
    found = caster.cast(origins, np.full(len(origins), angle), 100.0)
    to_the_wall = (29.0 - inside.sum(axis=1)) / math.sqrt(2.0)
    assert np.all(found <= to_the_wall + 1e-9)
    assert np.all(found >= to_the_wall - math.sqrt(2.0) / 2 - 1e-9)


def test_rays_nearly_along_an_axis_lose_no_digit() -> None:
    free = np.ones((3, 3000), dtype=bool)
    angles = np.array([1e-3, 3e-4, 1e-9, -1e-9, math.pi - 1e-9, math.pi + 5e-4])
    origins = np.column_stack([np.where(np.abs(angles) < 1, 1e-5, 2999.99999), np.full(6, 1.3)])
    expected = [naive(free, x, y, angle, 1e4) for (x, y), angle in zip(origins, angles, strict=True)]
    np.testing.assert_allclose(RayCaster.of(free).cast(origins, angles, 1e4), expected, rtol=1e-14)


@given(seeds)
def test_rectangles_are_empty_and_as_large_as_they_say(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wall = rng.random((2, rng.integers(1, 9), rng.integers(1, 12))) < 0.2
    sides = empty_squares(wall)
    widths = stretched_widths(wall, sides)
    for m, y, x in np.ndindex(*wall.shape):
        k, w = int(sides[m, y, x]), int(widths[m, y, x])
        assert k == largest_square(wall[m], y, x)
        if k:
            assert w >= k
            assert not wall[m, y : y + k, x : x + w].any()
            assert x + w == wall.shape[2] or wall[m, y : y + k, x + w].any()
        else:
            assert w == 0


def largest_square(wall: np.ndarray, y: int, x: int) -> int:
    side = 0
    while (
        max(y, x - wall.shape[1] + wall.shape[0]) + side < wall.shape[0]
        and not wall[y : y + side + 1, x : x + side + 1].any()
    ):
        side += 1
    return side


def test_no_ray_and_no_pose() -> None:
    caster = RayCaster.of(np.ones((2, 3)))
    assert caster.cast(np.zeros((0, 2)), np.zeros(0), 5.0).shape == (0,)
    assert caster.scans(np.zeros((0, 3)), np.zeros(4), 5.0).shape == (0, 4)
    assert caster.scans(np.zeros((2, 3)), np.zeros(0), 5.0).shape == (2, 0)
    assert caster.cast([[-1.0, 0.5], [9.0, 9.0]], [0.0, 1.0], 5.0).tolist() == [0.0, 0.0]


def test_a_map_may_lie_in_memory_by_columns_or_backwards() -> None:
    rng = np.random.default_rng(4)
    free = rng.random((20, 30)) > 0.1
    origins, angles = rng.uniform(0, 20, (200, 2)), rng.uniform(-4, 4, 200)
    for layout in (np.asfortranarray(free), free[::-1].copy()[::-1], np.rot90(np.rot90(free, 3).copy())):
        expected = cast_rays(free, origins, angles, 50.0)
        np.testing.assert_allclose(RayCaster.of(layout).cast(origins, angles, 50.0), expected, atol=1e-9)


def test_the_map_is_a_copy() -> None:
    free = np.ones((3, 3), dtype=bool)
    caster = RayCaster.of(free)
    free[:] = False
    assert caster.cast([[0.5, 0.5]], [0.0], 9.0)[0] == pytest.approx(2.5)


CASTER = RayCaster.of(np.ones((2, 2)))


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("free", lambda: RayCaster.of(np.ones(3))),
        ("free", lambda: RayCaster.of(np.ones((0, 2)))),
        ("free", lambda: RayCaster.of(np.ones((1, 2**15)))),
        ("origins", lambda: CASTER.cast([[0.5, math.nan]], [0.0], 5.0)),
        ("angles", lambda: CASTER.cast([[0.5, 0.5]], [math.nan], 5.0)),
        ("max_range", lambda: CASTER.cast([[0.5, 0.5]], [0.0], 0.0)),
        ("poses", lambda: CASTER.scans([0.5, 0.5, 0.0], [0.0], 5.0)),
        ("angles", lambda: CASTER.scans([[0.5, 0.5, 0.0]], 0.0, 5.0)),
    ],
)
def test_what_cannot_be_cast_is_named(argument: str, call: Any) -> None:
    with pytest.raises(RaycastError) as error:
        call()
    assert error.value.argument == argument
