"""The buffer of frames: against matrices and SciPy's rotations, and its faults by name."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from reference.frames import (
    NANOSECONDS,
    FrameBuffer,
    FrameError,
    FrameLoopError,
    FutureDateError,
    PastDateError,
    TooOldError,
    Transform,
    UnconnectedFramesError,
    UnknownFrameError,
    interpolate,
)
from reference.se2 import compose, inverse, relative

#: Whole dates of today: a float of seconds would not tell these apart.
START = 1_700_000_000_123_456_789
seeds = st.integers(0, 10_000)


def some_transform(rng: np.random.Generator) -> Transform:
    quaternion = rng.normal(size=4)
    return Transform(rng.normal(size=3), quaternion / np.linalg.norm(quaternion))


def matrix(T: Transform) -> np.ndarray:
    M = np.eye(4)
    M[:3, :3], M[:3, 3] = Rotation.from_quat(T.rotation).as_matrix(), T.translation
    return M


@given(seeds)
def test_transforms_compose_as_matrices_do(seed: int) -> None:
    rng = np.random.default_rng(seed)
    a, b = some_transform(rng), some_transform(rng)
    np.testing.assert_allclose(matrix(a.compose(b)), matrix(a) @ matrix(b), atol=1e-12)
    np.testing.assert_allclose(matrix(a.inverse()) @ matrix(a), np.eye(4), atol=1e-12)


@given(seeds, st.floats(0.0, 1.0))
def test_interpolation_is_that_of_scipy(seed: int, share: float) -> None:
    rng = np.random.default_rng(seed)
    a, b = some_transform(rng), some_transform(rng)
    found = interpolate(a, b, share)
    wanted = Slerp([0.0, 1.0], Rotation.from_quat([a.rotation, b.rotation]))([share])[0]
    assert (Rotation.from_quat(found.rotation) * wanted.inv()).magnitude() < 1e-7
    np.testing.assert_allclose(found.translation, (1 - share) * a.translation + share * b.translation)


def test_both_signs_of_a_quaternion_are_one_rotation() -> None:
    a, b = Transform.from_planar([0, 0, 3.0]), Transform.from_planar([2, 0, -3.0])
    for sign in (1.0, -1.0):
        middle = interpolate(a, Transform(b.translation, sign * b.rotation), 0.5).to_planar()
        np.testing.assert_allclose(np.abs(middle), [1.0, 0.0, np.pi], atol=1e-12)


@given(seeds, st.permutations(["map", "odom", "base", "laser", "camera", "wheel"]))
def test_any_two_frames_of_a_tree_are_joined(seed: int, names: list[str]) -> None:
    rng = np.random.default_rng(seed)
    buffer, in_root = FrameBuffer(), {names[0]: np.eye(4)}
    for k, child in enumerate(names[1:], 1):
        parent, T = names[rng.integers(k)], some_transform(rng)
        buffer.add(parent, child, T, START)
        in_root[child] = in_root[parent] @ matrix(T)
    for target in names:
        for source in names:
            wanted = np.linalg.inv(in_root[target]) @ in_root[source]
            np.testing.assert_allclose(matrix(buffer.lookup(target, source, START)), wanted, atol=1e-9)


def a_robot() -> FrameBuffer:
    """It turns a quarter to the left in a second while it advances by a metre, and its lidar looks backwards."""
    buffer = FrameBuffer()
    buffer.add("base_link", "laser", Transform.from_planar([0.2, 0.0, np.pi]), static=True)
    for k in range(3):
        buffer.add("odom", "base_link", Transform.from_planar([k, 0.0, k * np.pi / 2]), START + k * NANOSECONDS)
    return buffer


def test_a_scan_is_placed_at_its_own_date() -> None:
    buffer = a_robot()
    found = buffer.lookup("odom", "laser", START + NANOSECONDS // 4).to_planar()
    np.testing.assert_allclose(found, compose([0.25, 0.0, np.pi / 8], [0.2, 0.0, np.pi]), atol=1e-12)
    assert buffer.latest_common_stamp("odom", "laser") == START + 2 * NANOSECONDS
    assert buffer.latest_common_stamp("laser", "base_link") == 0
    assert buffer.latest_common_stamp("odom", "odom") == 0
    first, last = buffer.lookup("odom", "laser", START), buffer.lookup("odom", "laser", START + 5)
    moved = buffer.lookup_between("laser", START, "laser", START + 5, "odom").to_planar()
    np.testing.assert_allclose(moved, relative(first.to_planar(), last.to_planar()), atol=1e-15)
    assert moved[2] == pytest.approx(5e-9 * np.pi / 2, rel=1e-6)


def test_transforms_may_arrive_out_of_order_and_twice() -> None:
    buffer = FrameBuffer()
    for k in (4, 1, 3, 0, 2, 3):
        buffer.add("odom", "base", Transform.from_planar([k, 0, 0]), START + k)
    for before, after in pairwise(range(5)):
        for date in (before, after):
            assert buffer.lookup("odom", "base", START + date).to_planar()[0] == date
    buffer.add("odom", "base", Transform.from_planar([9, 0, 0]), START + 2)
    assert buffer.lookup("base", "/odom", START + 2).to_planar() == pytest.approx(inverse([9, 0, 0]))


def test_what_is_older_than_the_cache_is_forgotten() -> None:
    buffer = FrameBuffer(cache_ns=100)
    for date in (0, 60, 120):
        buffer.add("odom", "base", Transform.from_planar([date, 0, 0]), START + date)
    assert buffer.lookup("odom", "base", START + 60).to_planar()[0] == 60
    with pytest.raises(PastDateError, match="before the first odom -> base"):
        buffer.lookup("odom", "base", START + 40)
    with pytest.raises(TooOldError, match="late"):
        buffer.add("odom", "base", Transform.from_planar([0, 0, 0]), START + 19)


def test_a_child_that_changes_parents_begins_anew() -> None:
    buffer = a_robot()
    buffer.add("map", "odom", Transform.from_planar([0, 0, 0]), START)
    buffer.add("dock", "base_link", Transform.from_planar([5, 5, 0]), START)
    assert buffer.lookup("dock", "laser", START).to_planar()[:2] == pytest.approx([5.2, 5])
    with pytest.raises(UnconnectedFramesError, match="'dock'"):
        buffer.lookup("odom", "base_link", START)


@pytest.mark.parametrize(
    ("error", "argument", "call"),
    [
        (FutureDateError, "stamp_ns", lambda b: b.lookup("odom", "laser", START + 2 * NANOSECONDS + 1)),
        (PastDateError, "stamp_ns", lambda b: b.lookup("odom", "laser", START - 1)),
        (UnknownFrameError, "target", lambda b: b.lookup("map", "laser", START)),
        (UnknownFrameError, "source", lambda b: b.lookup("odom", "lazer", START)),
        (UnknownFrameError, "source", lambda b: b.latest_common_stamp("odom", "x")),
        (FrameLoopError, "parent", lambda b: b.add("laser", "odom", Transform.from_planar([0, 0, 0]), START)),
        (FrameLoopError, "parent", lambda b: b.add("laser", "laser", Transform.from_planar([0, 0, 0]), START)),
        (FrameError, "child", lambda b: b.add("odom", "/", Transform.from_planar([0, 0, 0]), START)),
        (FrameError, "cache_ns", lambda b: FrameBuffer(0)),
        (FrameError, "rotation", lambda b: Transform(np.zeros(3), np.zeros(4))),
        (FrameError, "rotation", lambda b: Transform(np.zeros(3), np.array([0.0, 0.0, 0.0, 2.0]))),
        (FrameError, "rotation", lambda b: Transform(np.zeros(3), np.array([0.0, 0.0, 1.0]))),
        (FrameError, "translation", lambda b: Transform(np.array([0, 0, np.nan]), np.array([0.0, 0.0, 0.0, 1.0]))),
        (
            FrameError,
            "rotation",
            lambda b: Transform(np.zeros(3), np.array([0.1, 0.0, 0.0, np.sqrt(0.99)])).to_planar(),
        ),
        (
            FrameError,
            "share",
            lambda b: interpolate(Transform.from_planar([0, 0, 0]), Transform.from_planar([0, 0, 0]), 1.1),
        ),
    ],
)
def test_each_fault_has_its_name(error: type[FrameError], argument: str, call: Any) -> None:
    with pytest.raises(error) as caught:
        call(a_robot())
    assert type(caught.value) is error
    assert caught.value.argument == argument
