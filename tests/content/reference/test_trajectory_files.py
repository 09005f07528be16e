"""Trajectory files: round trips to the last digit, SciPy's quaternions, and errors that name the line."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from reference.formats.trajectory_files import (
    Trajectory,
    TrajectoryFileError,
    read_kitti,
    read_tum,
    write_kitti,
    write_tum,
)

number = st.floats(-1e6, 1e6)
planar = st.lists(st.tuples(number, number, st.floats(-3.14, math.pi)), max_size=6).map(
    lambda rows: np.array(rows, dtype=float).reshape(-1, 3)
)


@given(planar)
def test_poses_of_the_plane_there_and_back(poses: np.ndarray) -> None:
    written = Trajectory.from_planar(1.7e9 + 0.1 * np.arange(len(poses)), poses)
    read = read_tum(write_tum(written))
    assert np.array_equal(read.times, written.times)
    assert np.array_equal(read.to_planar()[:, :2], poses[:, :2])
    np.testing.assert_allclose(read.to_planar()[:, 2], poses[:, 2], atol=1e-14)


@given(st.integers(0, 2**32 - 1))
def test_poses_of_space_there_and_back(seed: int) -> None:
    rng = np.random.default_rng(seed)
    turns = Rotation.from_rotvec(rng.normal(size=(5, 3)))
    written = Trajectory(np.arange(5.0), rng.normal(size=(5, 3)), turns.as_quat())
    read = read_tum(write_tum(written))
    np.testing.assert_allclose(read.quaternions, written.quaternions, atol=1e-15)
    np.testing.assert_allclose(read.to_matrices()[:, :3, :3], turns.as_matrix(), atol=1e-12)
    again = read_kitti(write_kitti(read.to_matrices()))
    assert np.array_equal(again, read.to_matrices())
    ahead = turns.apply([1.0, 0.0, 0.0])
    np.testing.assert_allclose(read.to_planar()[:, 2], np.arctan2(ahead[:, 1], ahead[:, 0]), atol=1e-12)


def test_a_line_as_the_benchmark_shows_it() -> None:
    text = "# ground truth\n# timestamp tx ty tz qx qy qz qw\n\n1305031098.6659 1.3 0.6 1.6 0 0 0.5 -0.86602540\n"
    read = read_tum(text)
    assert read.times.tolist() == [1305031098.6659]
    assert read.positions.tolist() == [[1.3, 0.6, 1.6]]
    assert read.to_planar()[0] == pytest.approx([1.3, 0.6, -math.pi / 3])


def test_a_file_without_poses_is_an_empty_trajectory() -> None:
    assert len(read_tum("# nothing\n")) == 0
    assert write_tum(read_tum("")) == ""
    assert read_tum("").to_planar().shape == (0, 3)
    assert read_tum("").to_matrices().shape == read_kitti("").shape == (0, 4, 4)


LINE = "0 1 2 3 0 0 0 1"


@pytest.mark.parametrize(
    ("argument", "message", "call"),
    [
        ("text", "line 2", lambda: read_tum(LINE + "\n0 1 2 3 0 0 0\n")),
        ("text", "line 1", lambda: read_tum("0 1 2 3 0 0 x 1")),
        ("text", "line 1", lambda: read_tum("0 1 2 3 0 0 nan 1")),
        ("text", "pose 2", lambda: read_tum(LINE + "\n0 1 2 3 0 0 1 1\n")),
        ("text", "line 1", lambda: read_kitti("1 0 0 0")),
        ("text", "rotation", lambda: read_kitti("2 0 0 0 0 1 0 0 0 0 1 0")),
        ("text", "rotation", lambda: read_kitti("-1 0 0 0 0 1 0 0 0 0 1 0")),
        ("matrices", "shape", lambda: write_kitti(np.zeros((2, 3, 4)))),
        ("poses", "shape", lambda: Trajectory.from_planar([0.0], [[1.0, 2.0]])),
        ("times", "finite", lambda: Trajectory.from_planar([math.nan], [[1.0, 2.0, 3.0]])),
        ("positions", "shape", lambda: Trajectory.from_planar([1.0, 2.0], [[1.0, 2.0, 3.0]])),
        ("quaternions", "pose 0", lambda: Trajectory(np.zeros(1), np.zeros((1, 3)), np.zeros((1, 4)))),
    ],
)
def test_what_is_no_trajectory_is_named(argument: str, message: str, call: Any) -> None:
    with pytest.raises(TrajectoryFileError, match=message) as error:
        call()
    assert error.value.argument == argument
