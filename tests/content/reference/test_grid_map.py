"""Grid maps: cells and metres, against homogeneous matrices and hand-made maps."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reference.se2 import compose, rotation_matrix
from reference.world.distance_map import DistanceMapError, chessboard_distances_to_cells, distances_to_cells
from reference.world.grid_map import GridMap, GridMapError

coordinate = st.floats(-50, 50)
corners = st.tuples(coordinate, coordinate, st.floats(-math.pi, math.pi))
grids = st.integers(0, 2**32 - 1).map(lambda seed: np.random.default_rng(seed).random((6, 9)) < 0.2)


@given(corners, st.floats(0.01, 2.0), st.lists(st.tuples(coordinate, coordinate), min_size=1, max_size=5))
def test_a_point_in_cells_is_where_the_matrix_says(corner: Any, resolution: float, points: Any) -> None:
    grid_map = GridMap.from_free(np.ones((3, 4)), resolution, corner)
    expected = [rotation_matrix(corner[2]) @ np.array(p) * resolution + np.array(corner[:2]) for p in points]
    np.testing.assert_allclose(grid_map.to_world(points), expected, atol=1e-9)
    np.testing.assert_allclose(grid_map.to_cells(expected), points, atol=1e-6)


@given(corners, corners)
def test_a_pose_goes_to_cells_and_back(corner: Any, pose: Any) -> None:
    grid_map = GridMap.from_free(np.ones((3, 4)), 1.0, corner)
    np.testing.assert_allclose(grid_map.poses_to_world([pose]), [compose(corner, pose)], atol=1e-9)
    back = grid_map.poses_to_cells(grid_map.poses_to_world(pose))
    np.testing.assert_allclose(back[:2], pose[:2], atol=1e-9)
    assert abs(math.remainder(back[2] - pose[2], math.tau)) < 1e-12


def test_free_points_are_those_on_free_cells() -> None:
    grid_map = GridMap(np.array([[1, 0, 0]]), np.array([[0, 1, 0]]), 0.5, np.array([1.0, 2.0, 0.0]))
    points = [[1.2, 2.2], [1.7, 2.2], [2.2, 2.2], [0.9, 2.2], [1.2, 2.6]]
    assert grid_map.is_free(points).tolist() == [True, False, False, False, False]
    assert grid_map.contains(points).tolist() == [True, True, True, False, False]
    assert grid_map.unknown_cells.tolist() == [[False, False, True]]
    assert grid_map.distances_to_wall.tolist() == [[0.5, 0.0, 0.5]]
    assert grid_map.is_free([1.2, 2.2])


@given(grids)
def test_distances_are_those_of_brute_force(cells: np.ndarray) -> None:
    if not cells.any():
        assert np.all(np.isinf(distances_to_cells(cells)))
        return
    gaps = np.abs(np.argwhere(np.ones_like(cells))[:, None] - np.argwhere(cells)[None])
    np.testing.assert_allclose(distances_to_cells(cells).ravel(), np.hypot(*gaps.T).min(axis=0), atol=1e-12)
    assert chessboard_distances_to_cells(cells).ravel().tolist() == gaps.max(axis=2).min(axis=1).tolist()


@given(grids, grids)
def test_drawings_there_and_back(free: np.ndarray, wall: np.ndarray) -> None:
    drawn = GridMap(free & ~wall, wall, 0.5, np.array([1.0, 2.0, 3.0]))
    again = GridMap.from_text(drawn.to_text(), 0.5, (1.0, 2.0, 3.0))
    assert np.array_equal(again.free, drawn.free)
    assert np.array_equal(again.occupied, drawn.occupied)


def test_a_drawing_starts_with_row_0() -> None:
    drawn = GridMap.from_text("""
        ##.
        #?.
    """)
    assert drawn.free.tolist() == [[False, False, True], [False, False, True]]
    assert drawn.unknown_cells.tolist() == [[False, False, False], [False, True, False]]
    assert drawn.to_text() == "##.\n#?.\n"


def test_scans_are_in_metres_wherever_the_map_lies() -> None:
    room = GridMap.from_free(np.ones((10, 20)), 0.1, (5.0, 5.0, np.pi / 2))
    ranges = room.cast_scans([[4.5, 6.0, np.pi / 2], [4.5, 6.0, 0.0], [9.0, 9.0, 0.0]], [0.0, np.pi], 0.8)
    np.testing.assert_allclose(ranges, [[0.8, 0.8], [0.5, 0.5], [0.0, 0.0]], atol=1e-12)


ONES = np.ones((2, 2))


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("free", lambda: GridMap.from_free(np.ones(3))),
        ("free", lambda: GridMap.from_free(np.ones((0, 3)))),
        ("occupied", lambda: GridMap(ONES, np.zeros((2, 3)), 1.0, np.zeros(3))),
        ("occupied", lambda: GridMap(ONES, ONES, 1.0, np.zeros(3))),
        ("resolution", lambda: GridMap.from_free(ONES, 0.0)),
        ("T_world_map", lambda: GridMap.from_free(ONES, 1.0, (0.0, math.nan, 0.0))),
        ("points_world", lambda: GridMap.from_free(ONES).to_cells([[0.0, math.nan]])),
        ("points_cells", lambda: GridMap.from_free(ONES).to_world([0.0, 1.0, 2.0])),
        ("poses_world", lambda: GridMap.from_free(ONES).poses_to_cells(1.0)),
        ("poses_cells", lambda: GridMap.from_free(ONES).poses_to_world([0.0, 1.0])),
        ("text", lambda: GridMap.from_text("")),
        ("text", lambda: GridMap.from_text("..\n.")),
        ("text", lambda: GridMap.from_text(".x")),
        ("cells", lambda: distances_to_cells(np.ones(3))),
        ("cells", lambda: chessboard_distances_to_cells(np.zeros((2, 2)))),
    ],
)
def test_what_is_no_map_is_named(argument: str, call: Any) -> None:
    with pytest.raises((GridMapError, DistanceMapError)) as error:
        call()
    assert error.value.argument == argument
