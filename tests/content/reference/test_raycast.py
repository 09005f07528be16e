"""Ray casting: against the students' kit, against a brute-force walk over the sides of every wall, and by geometry."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from graders.core.contract.local import kit_source
from reference.world.raycast import RaycastError, cast_rays, cast_scans

RANGE = 9.0


def random_grid(rng: np.random.Generator, shape: tuple[int, int] = (9, 12)) -> np.ndarray:
    return np.asarray(rng.random(shape) > 0.25)


def origins_in(grid: np.ndarray, rng: np.random.Generator, count: int) -> np.ndarray:
    cells = np.argwhere(grid)[rng.integers(np.count_nonzero(grid), size=count)]
    return cells[:, ::-1] + rng.uniform(0.05, 0.95, (count, 2))


def slab_distance(grid: np.ndarray, origin: np.ndarray, angle: float) -> float:
    """The nearest entry among all wall cells and the outside, each treated as a box: no walk, no grid line."""
    height, width = grid.shape
    direction = np.array([math.cos(angle), math.sin(angle)])
    best = RANGE
    for y in range(-1, height + 1):
        for x in range(-1, width + 1):
            inside = 0 <= y < height and 0 <= x < width
            if inside and grid[y, x]:
                continue
            low, high = (np.array([x, y]) - origin) / direction, (np.array([x + 1, y + 1]) - origin) / direction
            enter, leave = np.minimum(low, high).max(), np.maximum(low, high).min()
            if 0 <= enter < leave:
                best = min(best, float(enter))
    return best


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_distances_are_those_of_the_nearest_box(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = random_grid(rng, (5, 7))
    if not grid.any():
        return
    origins, angles = origins_in(grid, rng, 6), rng.uniform(-math.pi, math.pi, 6)
    expected = [slab_distance(grid, origin, angle) for origin, angle in zip(origins, angles, strict=True)]
    assert np.allclose(cast_rays(grid, origins, angles, RANGE), expected, atol=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_scans_are_those_of_the_kit(seed: int) -> None:
    rng = np.random.default_rng(seed)
    grid = random_grid(rng)
    kit: dict[str, object] = {"__name__": "l20"}
    exec(compile(kit_source("l20"), "l20.py", "exec"), kit)
    names = kit["configurer"](libres=grid, portee_max=RANGE, seed=1)  # type: ignore[operator]
    poses = np.column_stack([rng.uniform(-1, 13, 300), rng.uniform(-1, 10, 300), rng.uniform(-4, 4, 300)])
    assert np.allclose(cast_scans(grid, poses, 7, RANGE), names["lidar_lot"](poses, 7), atol=1e-9)
    centres = np.column_stack([np.argwhere(grid)[:, ::-1] + 0.5, np.zeros(np.count_nonzero(grid))])
    one_by_one = [names["lidar"](pose, 4) for pose in centres]
    assert np.allclose(cast_scans(grid, centres, 4, RANGE), one_by_one, atol=1e-12)


def test_an_empty_room_measured_along_the_axes() -> None:
    grid = np.ones((4, 6), dtype=bool)
    assert cast_scans(grid, [[1.25, 3.0, 0.0]], 4, 50.0)[0] == pytest.approx([4.75, 1.0, 1.25, 3.0], abs=1e-12)
    assert cast_scans(grid, [[1.25, 3.0, 0.0]], 4, 2.0)[0] == pytest.approx([2.0, 1.0, 1.25, 2.0], abs=1e-12)


def test_a_diagonal_gap_between_two_walls_stops_no_ray_that_crosses_a_side() -> None:
    grid = np.array([[True, True, True], [True, False, True], [True, True, True]])
    assert cast_rays(grid, [[0.5, 0.5]], [0.0], 9.0)[0] == pytest.approx(2.5)
    assert cast_rays(grid, [[0.5, 0.2]], [math.pi / 4], 9.0)[0] == pytest.approx(0.8 * math.sqrt(2.0))


def test_from_a_wall_or_from_outside_a_ray_reads_zero() -> None:
    grid = np.array([[True, False]])
    assert cast_rays(grid, [[1.5, 0.5], [-0.5, 0.5], [0.5, 7.0]], [0.0, 1.0, 2.0], 5.0).tolist() == [0.0, 0.0, 0.0]


def test_no_ray_gives_no_distance() -> None:
    assert cast_rays(np.ones((2, 2), dtype=bool), np.zeros((0, 2)), np.zeros(0), 5.0).shape == (0,)


@pytest.mark.parametrize(
    ("argument", "change"),
    [
        ("free", {"free": np.ones(3, dtype=bool)}),
        ("free", {"free": np.ones((0, 3), dtype=bool)}),
        ("origins", {"origins": [[0.5, math.nan]]}),
        ("origins", {"origins": [[0.5, 0.5, 0.5]]}),
        ("angles", {"angles": [math.inf]}),
        ("max_range", {"max_range": 0.0}),
        ("max_range", {"max_range": math.inf}),
    ],
)
def test_what_cannot_be_cast_is_named(argument: str, change: dict[str, object]) -> None:
    given_: dict[str, object] = {
        "free": np.ones((2, 2), dtype=bool), "origins": [[0.5, 0.5]], "angles": [0.0], "max_range": 5.0, **change,
    }  # fmt: skip
    with pytest.raises(RaycastError) as error:
        cast_rays(**given_)  # type: ignore[arg-type]
    assert error.value.argument == argument


def test_poses_and_beams_are_checked() -> None:
    grid = np.ones((2, 2), dtype=bool)
    for poses, beams, argument in ((np.zeros((1, 2)), 4, "poses"), (np.zeros((1, 3)), 0, "beams")):
        with pytest.raises(RaycastError) as error:
            cast_scans(grid, poses, beams, 5.0)
        assert error.value.argument == argument
