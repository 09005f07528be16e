"""The fast ray caster: against the walk from cell to cell, a naive one, and clear cones counted one cell at a time."""

import math
from fractions import Fraction
from typing import Any, TypeVar

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.ndimage import label

from reference.world import ray_caster
from reference.world.clear_cones import MOST, clear_cone_lengths, clear_leap_lengths
from reference.world.ray_caster import RayCaster
from reference.world.raycast import RaycastError, cast_rays, cast_scans

seeds = st.integers(0, 2**32 - 1)


Number = TypeVar("Number", float, Fraction)


def walked(free: np.ndarray, x: Number, y: Number, dx: Number, dy: Number, max_range: float) -> Number | float:
    """From cell to cell, each line's time computed afresh from the line itself."""
    column, row = math.floor(x), math.floor(y)
    time: Number | float = 0.0
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


def naive(free: np.ndarray, x: float, y: float, angle: float, max_range: float) -> float:
    return walked(free, x, y, math.cos(angle), math.sin(angle), max_range)


def exact(free: np.ndarray, x: float, y: float, angle: float) -> float:
    """In fractions, along the direction that the computer's cosine and sine are."""
    direction = Fraction(math.cos(angle)), Fraction(math.sin(angle))
    return float(walked(free, Fraction(x), Fraction(y), *direction, math.inf))


@settings(deadline=None)
@given(seeds, st.floats(0.0, 0.6), st.sampled_from([3.0, 11.0, 60.0]), st.sampled_from([0, 200, 8192]))
def test_distances_are_those_of_the_walks(seed: int, walls: float, max_range: float, last: int) -> None:
    """However many rays are left to the end, and in however many blocks."""
    rng = np.random.default_rng(seed)
    free = rng.random((rng.integers(1, 25), rng.integers(1, 25))) >= walls
    origins = rng.uniform(-1.0, 1.0 + np.array(free.shape[::-1]), (60, 2))
    angles = rng.uniform(-math.pi, math.pi, 60)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ray_caster, "LAST_PLACES", last)
        patch.setattr(ray_caster, "BLOCK", 25 if last else 16384)
        found = RayCaster.from_free_cells(free).cast(origins, angles, max_range)
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
    found = RayCaster.from_free_cells(free).cast_scans(poses, 2 * np.pi * np.arange(30) / 30, 300.0)
    np.testing.assert_allclose(found, cast_scans(free, poses, 30, 300.0), atol=1e-9)


@pytest.mark.parametrize("block", [1, 20, 25, 16384])
def test_scans_are_the_same_in_however_many_blocks(block: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A block holds whole scans: of one pose, if a scan alone fills it; the last one may hold fewer."""
    rng = np.random.default_rng(3)
    free = rng.random((20, 30)) > 0.2
    poses = rng.uniform([0.0, 0.0, -np.pi], [30.0, 20.0, np.pi], (7, 3))
    monkeypatch.setattr(ray_caster, "BLOCK", block)
    found = RayCaster.from_free_cells(free).cast_scans(poses, 2 * np.pi * np.arange(10) / 10, 50.0)
    np.testing.assert_allclose(found, cast_scans(free, poses, 10, 50.0), atol=1e-9)


@pytest.mark.parametrize("bits", [ray_caster.BITS, 50])
@pytest.mark.parametrize("angle", [k * math.pi / 2 for k in range(-3, 5)] + [0.0, -0.0])
def test_along_the_axes_even_from_the_lines_themselves(
    angle: float, bits: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From corners and sides of cells too, where rays run along a line: as the walk has it, in coarse units too."""
    monkeypatch.setattr(ray_caster, "BITS", bits)
    rng = np.random.default_rng(9)
    free = rng.random((9, 12)) > 0.2
    origins = np.stack(np.meshgrid(np.arange(0, 12, 0.5), np.arange(0, 9, 0.5)), axis=-1).reshape(-1, 2)
    angles = np.full(len(origins), angle)
    expected = cast_rays(free, origins, angles, 50.0)
    np.testing.assert_allclose(
        RayCaster.from_free_cells(free).cast(origins, angles, 50.0), expected, rtol=1e-14, atol=1e-300
    )


def test_through_the_corners_of_cells_a_ray_enters_one_of_the_neighbours() -> None:
    """Diagonals from the centres of cells: rounding may choose the side, but no ray gets past a closed corner."""
    free = np.array([[1, 1, 0, 1], [1, 1, 1, 1], [1, 1, 1, 1]], dtype=bool)
    caster = RayCaster.from_free_cells(free)
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
    caster, origins = RayCaster.from_free_cells(np.rot90(free, quarter)), inside[:, ::-1] + 0.5
    angle = math.pi / 4
    for _ in range(quarter):
        origins, angle = np.column_stack([origins[:, 1], 30.0 - origins[:, 0]]), angle - math.pi / 2
    found = caster.cast(origins, np.full(len(origins), angle), 100.0)
    to_the_wall = (29.0 - inside.sum(axis=1)) / math.sqrt(2.0)
    assert np.all(found <= to_the_wall + 1e-9)
    assert np.all(found >= to_the_wall - math.sqrt(2.0) / 2 - 1e-9)


def test_a_ray_that_lands_where_it_starts_stays_there_while_others_fly(monkeypatch: pytest.MonkeyPatch) -> None:
    """From the very line behind which there is a wall, all but along it, in the company of rays far from landing."""
    monkeypatch.setattr(ray_caster, "LAST_PLACES", 0)
    free = np.ones((40, 400), dtype=bool)
    free[3] = False
    origins = np.array([[5.5, 4.0]] + [[1.5, 20.5]] * 50)
    angles = np.append(-1e-17, np.linspace(0.01, 0.4, 50))
    found = RayCaster.from_free_cells(free).cast(origins, angles, 1e3)
    assert found[0] == 0.0
    np.testing.assert_allclose(found, cast_rays(free, origins, angles, 1e3), atol=1e-9)


def test_rays_nearly_along_an_axis_lose_no_digit() -> None:
    free = np.ones((3, 3000), dtype=bool)
    angles = np.array([1e-3, 3e-4, 1e-9, -1e-9, math.pi - 1e-9, math.pi + 5e-4])
    origins = np.column_stack([np.where(np.abs(angles) < 1, 1e-5, 2999.99999), np.full(6, 1.3)])
    expected = [naive(free, x, y, angle, 1e4) for (x, y), angle in zip(origins, angles, strict=True)]
    np.testing.assert_allclose(RayCaster.from_free_cells(free).cast(origins, angles, 1e4), expected, rtol=1e-14)
    # Just above a line that is crossed soon, with a wall further on in the one row and not in the other.
    hall = np.ones((9, 20), dtype=bool)
    hall[7, 12] = False
    assert RayCaster.from_free_cells(hall).cast([[3.5, 7.000000000000002]], [-1.2722218725854067e-14], 99.0)[
        0
    ] == pytest.approx(16.5)


@pytest.mark.parametrize("bits", [ray_caster.BITS, 50])
def test_diagonals_take_the_neighbours_of_their_exact_lines(bits: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """From centres, sides and corners of cells: their sine and cosine differ by one digit, which tells who is first."""
    monkeypatch.setattr(ray_caster, "BITS", bits)
    rng = np.random.default_rng(12)
    free = rng.random((12, 16)) > 0.2
    origins = rng.integers(0, [32, 24], (150, 2)) / 2.0
    angles = rng.choice([-3, -1, 1, 3, 5], 150) * math.pi / 4
    rays = zip(origins.tolist(), angles.tolist(), strict=True)
    expected = [exact(free, x, y, angle) for (x, y), angle in rays]
    np.testing.assert_allclose(RayCaster.from_free_cells(free).cast(origins, angles, 50.0), expected, atol=1e-12)


@settings(deadline=None)
@given(seeds, st.sampled_from([0, 8192]))
def test_no_ray_leaves_the_cells_that_sides_join_to_its_own(seed: int, last: int) -> None:
    """From corners, middles of sides and centres of cells, towards other such points: nothing but ties."""
    rng = np.random.default_rng(seed)
    free = rng.random((10, 13)) > 0.45
    origins = rng.integers(0, [26, 20], (80, 2)) / 2.0
    aims = rng.integers(1, 5, (80, 2)) * rng.choice([-1, 1], (80, 2))
    angles = np.arctan2(aims[:, 1], aims[:, 0])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ray_caster, "LAST_PLACES", last)
        found = RayCaster.from_free_cells(free).cast(origins, angles, 99.0)
    assert np.array_equal(found > 0.0, cast_rays(free, origins, angles, 99.0) > 0.0)
    rooms, _ = label(free)
    directions = np.column_stack([np.cos(angles), np.sin(angles)])
    for origin, end in zip(origins, origins + found[:, None] * directions, strict=True):
        column, row = np.floor(origin).astype(int)
        if free[row, column]:
            corners = np.argwhere(rooms == rooms[row, column])[:, ::-1]
            off = np.maximum(corners - end, end - (corners + 1)).max(axis=1)
            assert off.min() < 1e-9


def test_leaps_longer_than_a_count_holds_and_walls_one_cell_thick() -> None:
    """A corridor of 2000 cells whose walls are a step away, along both axes, and a comb of walls with gaps in it."""
    rng = np.random.default_rng(6)
    corridor, comb = np.ones((5, 2000), dtype=bool), np.ones((60, 60), dtype=bool)
    corridor[2, 1990] = False
    comb[::4], comb[np.arange(0, 60, 4), rng.integers(0, 60, 15)] = False, True
    for free in (corridor, corridor.T, comb, comb.T):
        origins = rng.uniform(0.0, free.shape[::-1], (300, 2))
        angles = rng.choice(4, 300) * math.pi / 2 + rng.normal(0.0, 0.02, 300)
        expected = [naive(free, x, y, angle, 1e4) for (x, y), angle in zip(origins, angles, strict=True)]
        np.testing.assert_allclose(RayCaster.from_free_cells(free).cast(origins, angles, 1e4), expected, rtol=1e-13)


@given(seeds, st.integers(1, 4))
def test_cones_are_empty_and_as_long_as_they_say(seed: int, sectors: int) -> None:
    rng = np.random.default_rng(seed)
    wall = rng.random((2, rng.integers(1, 9), rng.integers(1, 9))) < 0.12
    for k in range(sectors):
        found = clear_cone_lengths(wall, k, sectors)
        for m, i, r in np.ndindex(*wall.shape):
            assert found[m, i, r] == empty_columns(wall[m], i, r, Fraction(k, sectors), Fraction(k + 1, sectors))


def empty_columns(wall: np.ndarray, i: int, r: int, least: Fraction, greatest: Fraction) -> int:
    """Column by column: rays from the foot of a cell's side with the least slope, from its top with the greatest."""
    count, almost = 0, 1 - Fraction(1, 1000)
    while i + count < len(wall):
        rows = range(r + math.floor(count * least), r + math.floor(almost + (count + 1) * greatest) + 1)
        if any(row >= wall.shape[1] or wall[i + count, row] for row in rows):
            break
        count += 1
    return count


@given(seeds)
def test_leaps_are_of_rays_that_stay_in_a_row_and_of_rays_that_leave_it(seed: int) -> None:
    rng = np.random.default_rng(seed)
    wall = np.pad(rng.random((1, 5, 6)) < 0.15, ((0, 0), (1, 1), (1, 1)), constant_values=True)
    found = clear_leap_lengths(wall, 2)[0]
    for k, i, r, rises in np.ndindex(2, 6, 7, 2):
        stopped = wall[0, i, r] or (rises and wall[0, i, r + 1])
        further = empty_columns(wall[0], i + 1, r + rises, Fraction(k, 2), Fraction(k + 1, 2))
        assert found[k, i, r, rises] == (0 if stopped else 1 + further)


def test_counts_stop_where_a_byte_does() -> None:
    for sectors in (1, 2, 3):
        found = clear_leap_lengths(
            np.pad(np.zeros((1, 700, 700), dtype=bool), ((0, 0), (1, 1), (1, 1)), constant_values=True), sectors
        )
        assert MOST - sectors <= found.max() <= MOST
        assert found[0, 0, 1, 1, 0] == found.max()
        assert not found[:, :, [0, -1]].any()
        assert found[0, 0, 698, 1].tolist() == [3, 3]


def test_what_stands_in_a_wall_or_off_the_map_reads_zero_without_a_sign() -> None:
    caster = RayCaster.from_free_cells([[True, False, True]])
    origins = [(1.5, 0.5), (1.0, 0.0), (-0.1, 0.5), (9.0, -9.0), (0.5, 1.0)]
    for angle in (0.0, 1.0, np.pi, -2.0):
        read = caster.cast(origins, [angle] * len(origins), 5.0)
        assert not read.any()
        assert not np.signbit(read).any()


def test_no_ray_and_no_pose() -> None:
    caster = RayCaster.from_free_cells(np.ones((2, 3)))
    assert caster.cast(np.zeros((0, 2)), np.zeros(0), 5.0).shape == (0,)
    assert caster.cast_scans(np.zeros((0, 3)), np.zeros(4), 5.0).shape == (0, 4)
    assert caster.cast_scans(np.zeros((2, 3)), np.zeros(0), 5.0).shape == (2, 0)
    assert caster.cast([[-1.0, 0.5], [9.0, 9.0]], [0.0, 1.0], 5.0).tolist() == [0.0, 0.0]


def test_a_map_may_lie_in_memory_by_columns_or_backwards() -> None:
    rng = np.random.default_rng(4)
    free = rng.random((20, 30)) > 0.1
    origins, angles = rng.uniform(0, 20, (200, 2)), rng.uniform(-4, 4, 200)
    for layout in (np.asfortranarray(free), free[::-1].copy()[::-1], np.rot90(np.rot90(free, 3).copy())):
        expected = cast_rays(free, origins, angles, 50.0)
        np.testing.assert_allclose(RayCaster.from_free_cells(layout).cast(origins, angles, 50.0), expected, atol=1e-9)


def test_the_map_is_a_copy() -> None:
    free = np.ones((3, 3), dtype=bool)
    caster = RayCaster.from_free_cells(free)
    free[:] = False
    assert caster.cast([[0.5, 0.5]], [0.0], 9.0)[0] == pytest.approx(2.5)


CASTER = RayCaster.from_free_cells(np.ones((2, 2)))


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("free", lambda: RayCaster.from_free_cells(np.ones(3))),
        ("free", lambda: RayCaster.from_free_cells(np.ones((0, 2)))),
        ("free", lambda: RayCaster.from_free_cells(np.ones((1, 2**15)))),
        ("origins", lambda: CASTER.cast([[0.5, math.nan]], [0.0], 5.0)),
        ("angles", lambda: CASTER.cast([[0.5, 0.5]], [math.nan], 5.0)),
        ("max_range", lambda: CASTER.cast([[0.5, 0.5]], [0.0], 0.0)),
        ("poses", lambda: CASTER.cast_scans([0.5, 0.5, 0.0], [0.0], 5.0)),
        ("angles", lambda: CASTER.cast_scans([[0.5, 0.5, 0.0]], 0.0, 5.0)),
    ],
)
def test_what_cannot_be_cast_is_named(argument: str, call: Any) -> None:
    with pytest.raises(RaycastError) as error:
        call()
    assert error.value.argument == argument
