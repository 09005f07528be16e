"""Errors of trajectories: evo's values, SciPy's rotations, and what their definitions say."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from reference.formats.relations import RelationsError, parse_relations
from reference.formats.trajectory_files import read_kitti
from reference.metrics import (
    MetricError,
    absolute_trajectory_error,
    matching_times,
    relation_error,
    relative_pose_error,
)
from reference.se2 import compose, relative, to_matrix

seeds = st.integers(0, 2**32 - 1)


def path(rng: np.random.Generator, n: int = 12) -> np.ndarray:
    poses = [rng.normal(size=3)]
    for _ in range(n - 1):
        poses.append(compose(poses[-1], rng.normal([1.0, 0.0, 0.1], [0.3, 0.1, 0.4])))
    return np.array(poses)


def noisy(rng: np.random.Generator, poses: np.ndarray) -> np.ndarray:
    return poses + rng.normal(0, 0.1, poses.shape)


def test_the_published_error_of_orb_slam_on_kitti(dataset: Callable[[str], bytes]) -> None:
    """evo_ape kitti KITTI_00_gt.txt KITTI_00_ORB.txt -va: rmse 1.303450 (here with the digits of evo 1.38)."""
    truth = read_kitti(dataset("traj/KITTI_00_gt.txt").decode())
    estimate = read_kitti(dataset("traj/KITTI_00_ORB.txt").decode())
    rigid = absolute_trajectory_error(truth, estimate)
    assert rigid.rmse == pytest.approx(1.3034497145650, abs=1e-10)
    assert rigid.mean == pytest.approx(1.1569971285389946, abs=1e-10)
    assert rigid.median == pytest.approx(1.0656247695558074, abs=1e-10)
    assert rigid.std == pytest.approx(0.6002822693968386, abs=1e-10)
    assert rigid.min == pytest.approx(0.06931322021483205, abs=1e-10)
    assert rigid.max == pytest.approx(3.587949120678975, abs=1e-10)
    assert rigid.sse == pytest.approx(7715.073440293025, rel=1e-12)
    for align, rmse in (("similarity", 0.937709073611404), ("first", 7.790305225236266), ("none", 7.790288882656827)):
        assert absolute_trajectory_error(truth, estimate, align).rmse == pytest.approx(rmse, abs=1e-10)


@pytest.mark.parametrize(
    ("delta", "unit", "overlapping", "pairs", "translation", "rotation"),
    [
        (1, "poses", False, 4540, 0.028120377017393856, 0.002006666498595074),
        (10, "poses", False, 454, 0.19400775757968894, 0.010880555061948793),
        (10, "poses", True, 4531, 0.18934823038597612, 0.010672134557820801),
        (100.0, "metres", False, 36, 1.1939759245846355, 0.01272058124414061),
    ],
)
def test_relative_errors_are_those_of_evo(
    dataset: Callable[[str], bytes],
    delta: float,
    unit: Any,
    overlapping: bool,
    pairs: int,
    translation: float,
    rotation: float,
) -> None:
    truth = read_kitti(dataset("traj/KITTI_00_gt.txt").decode())
    estimate = read_kitti(dataset("traj/KITTI_00_ORB.txt").decode())
    found = relative_pose_error(truth, estimate, delta, unit, overlapping)
    assert len(found.pairs) == pairs
    assert found.translation.rmse == pytest.approx(translation, abs=1e-10)
    assert found.rotation.rmse == pytest.approx(rotation, abs=1e-10)


@given(seeds)
def test_the_alignment_undoes_any_motion_of_the_whole(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth, T = path(rng), rng.normal(size=3)
    moved = compose(T, truth)
    assert absolute_trajectory_error(truth, moved).max < 1e-9
    assert absolute_trajectory_error(truth, moved, "first").max < 1e-9
    scaled = moved * [2.5, 2.5, 1.0]
    found = absolute_trajectory_error(truth, scaled, "similarity")
    assert found.max < 1e-9
    assert found.scale == pytest.approx(0.4)
    np.testing.assert_allclose(found.aligned, truth[:, :2], atol=1e-9)
    gaps = np.hypot(*(truth - moved)[:, :2].T)
    np.testing.assert_allclose(absolute_trajectory_error(truth, moved, "none").values, gaps, atol=1e-12)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("align", ["rigid", "similarity"])
def test_no_other_alignment_does_better(seed: int, align: Any) -> None:
    rng = np.random.default_rng(seed)
    truth = path(rng)
    estimate = noisy(rng, truth)
    found = absolute_trajectory_error(truth, estimate, align)

    def cost(z: np.ndarray) -> float:
        scale = z[3] if align == "similarity" else 1.0
        c, s = math.cos(z[2]), math.sin(z[2])
        moved = scale * estimate[:, :2] @ np.array([[c, s], [-s, c]]) + z[:2]
        return float(np.sum((truth[:, :2] - moved) ** 2))

    best = minimize(cost, [0.0, 0.0, 0.0, 1.0], method="BFGS", options={"gtol": 1e-10})
    assert found.sse == pytest.approx(best.fun, rel=1e-7)


@given(seeds, st.integers(1, 5), st.booleans())
def test_relative_errors_are_their_definition_in_poses(seed: int, delta: int, overlapping: bool) -> None:
    rng = np.random.default_rng(seed)
    truth = path(rng)
    estimate = noisy(rng, truth)
    found = relative_pose_error(truth, estimate, delta, overlapping=overlapping)
    starts = range(0, 12 - delta, 1 if overlapping else delta)
    assert found.pairs.tolist() == [[i, i + delta] for i in starts]
    for k, (i, j) in enumerate(found.pairs):
        E = relative(relative(truth[i], truth[j]), relative(estimate[i], estimate[j]))
        assert found.translation.values[k] == pytest.approx(math.hypot(E[0], E[1]), abs=1e-12)
        assert found.rotation.values[k] == pytest.approx(abs(E[2]), abs=1e-12)


@given(seeds)
def test_relative_errors_do_not_see_where_the_whole_lies(seed: int) -> None:
    rng = np.random.default_rng(seed)
    truth = path(rng)
    moved = compose(rng.normal(size=3), truth)
    found = relative_pose_error(truth, moved)
    assert found.translation.max < 1e-9
    assert found.rotation.max < 1e-9


@given(seeds)
def test_the_plane_is_a_part_of_space(seed: int) -> None:
    """Poses (n, 3), their matrices, and the same lifted to three dimensions have the same errors."""
    rng = np.random.default_rng(seed)
    truth = path(rng)
    estimate = noisy(rng, truth)
    lifted = []
    for poses in (truth, estimate):
        M = np.tile(np.eye(4), (len(poses), 1, 1))
        M[:, :3, :3] = Rotation.from_rotvec(poses[:, 2:] * [0.0, 0.0, 1.0]).as_matrix()
        M[:, :2, 3] = poses[:, :2]
        lifted.append(M)
    flat = absolute_trajectory_error(truth, estimate)
    np.testing.assert_allclose(absolute_trajectory_error(*map(to_matrix, (truth, estimate))).values, flat.values)
    np.testing.assert_allclose(absolute_trajectory_error(*lifted).values, flat.values, atol=1e-9)
    one, other = relative_pose_error(truth, estimate), relative_pose_error(*lifted)
    np.testing.assert_allclose(other.translation.values, one.translation.values, atol=1e-9)
    np.testing.assert_allclose(other.rotation.values, one.rotation.values, atol=1e-9)


def test_statistics_by_hand() -> None:
    truth = np.zeros((3, 3))
    found = absolute_trajectory_error(truth, [[3.0, 4.0, 0.0], [0.0, 1.0, 9.0], [0.0, 0.0, 0.0]], "none")
    assert found.values.tolist() == [5.0, 1.0, 0.0]
    assert (found.mean, found.median, found.min, found.max, found.sse) == (2.0, 1.0, 0.0, 5.0, 26.0)
    assert found.rmse == pytest.approx(math.sqrt(26 / 3))
    assert found.std == pytest.approx(math.sqrt(26 / 3 - 4))


@given(st.sets(st.integers(0, 60)), st.sets(st.integers(0, 60)), st.integers(0, 5))
def test_matching_times_are_those_of_brute_force(ones: set[int], others: set[int], apart: int) -> None:
    """Whole numbers, so that halves of the gap are exact; among equals the earlier one is the nearest."""
    a, b = sorted(ones), sorted(others)
    expected = []
    for i, time in enumerate(a):
        if not b:
            break
        j = min(range(len(b)), key=lambda k, t=time: (abs(b[k] - t), k))
        back = min(range(len(a)), key=lambda k, t=b[j]: (abs(a[k] - t), k))
        if back == i and abs(b[j] - time) <= apart:
            expected.append([i, j])
    assert matching_times(a, b, apart).tolist() == expected


PATH = path(np.random.default_rng(1))
LINE = np.column_stack([np.arange(5.0), np.zeros(5), np.zeros(5)])


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("truth", lambda: absolute_trajectory_error(np.zeros((0, 3)), np.zeros((0, 3)))),
        ("truth", lambda: absolute_trajectory_error(np.zeros((4, 2)), PATH)),
        ("estimate", lambda: absolute_trajectory_error(PATH, PATH * math.nan)),
        ("estimate", lambda: absolute_trajectory_error(PATH, PATH[:5])),
        ("estimate", lambda: absolute_trajectory_error(PATH, np.tile(PATH[0], (12, 1)))),
        ("estimate", lambda: absolute_trajectory_error(np.tile(np.eye(4), (5, 1, 1)), np.tile(np.eye(4), (5, 1, 1)))),
        ("truth", lambda: matching_times([1.0, 1.0], [1.0])),
        ("estimate", lambda: matching_times([1.0], [[1.0]])),
        ("max_difference", lambda: matching_times([1.0], [1.0], math.nan)),
        ("delta", lambda: relative_pose_error(PATH, PATH, 0)),
        ("delta", lambda: relative_pose_error(PATH, PATH, 1.5)),
        ("delta", lambda: relative_pose_error(PATH, PATH, 12)),
        ("delta", lambda: relative_pose_error(PATH, PATH, 12, overlapping=True)),
        ("delta", lambda: relative_pose_error(LINE, LINE, 9.0, "metres")),
        ("delta", lambda: relative_pose_error(LINE, LINE, -1.0, "metres")),
    ],
)
def test_what_cannot_be_compared_is_named(argument: str, call: Any) -> None:
    with pytest.raises(MetricError) as error:
        call()
    assert error.value.argument == argument


def test_metres_are_counted_along_the_path() -> None:
    assert relative_pose_error(LINE, LINE, 2.0, "metres").pairs.tolist() == [[0, 2], [2, 4]]
    assert relative_pose_error(LINE, LINE, 1.5, "metres").pairs.tolist() == [[0, 2], [2, 4]]


@given(seed=seeds, n=st.integers(2, 12), m=st.integers(1, 20))
def test_errors_by_relations_are_those_of_the_definition(seed: int, n: int, m: int) -> None:
    """By homogeneous matrices, one relation at a time; wherever the estimate lies, and none where it is right."""
    rng = np.random.default_rng(seed)
    estimate, moved = path(rng, n), rng.normal(size=3)
    pairs, Z = rng.integers(0, n, (m, 2)), rng.normal(size=(m, 3))
    found = relation_error(compose(moved, estimate), pairs, Z)
    for k, (i, j) in enumerate(pairs):
        E = np.linalg.inv(to_matrix(Z[k])) @ np.linalg.inv(to_matrix(estimate[i])) @ to_matrix(estimate[j])
        assert found.translation.values[k] == pytest.approx(np.hypot(E[0, 2], E[1, 2]), abs=1e-9)
        assert found.rotation.values[k] == pytest.approx(abs(math.atan2(E[1, 0], E[0, 0])), abs=1e-9)
    assert found.translation.squared.mean == pytest.approx(np.mean(found.translation.values**2))
    right = relation_error(estimate, pairs, relative(estimate[pairs[:, 0]], estimate[pairs[:, 1]]))
    assert max(right.translation.max, right.rotation.max) < 1e-7
    matrices = relation_error(to_matrix(estimate), pairs, to_matrix(Z))
    np.testing.assert_allclose(matrices.translation.values, found.translation.values, atol=1e-9)


@given(
    st.lists(st.integers(0, 40), min_size=0, max_size=12, unique=True),
    st.lists(st.tuples(st.integers(0, 40), st.integers(0, 40)), max_size=10),
)
def test_relations_are_paired_with_the_scans_of_their_times(stamps: Any, told: Any) -> None:
    text = "".join(f"{a / 8} {b / 8} 1 2 0 0 0 {k / 10}\n" for k, (a, b) in enumerate(told))
    relations = parse_relations("# relations\n\n" + text)
    pairs, T = relations.select_between_times([stamp / 8 for stamp in stamps])
    wanted = [(stamps.index(a), stamps.index(b), k / 10) for k, (a, b) in enumerate(told) if {a, b} <= set(stamps)]
    assert len(relations) == len(told)
    assert [(i, j, theta) for (i, j), theta in zip(pairs.tolist(), T[:, 2].tolist(), strict=True)] == wanted


NO_RELATIONS = ["1 2 3", "1 2 0 0 0 0 0 x", "1 2 0 0 0 0 0 nan", "1 2 0 0 0.5 0 0 0", "1 2 3 4 0 0 0 0 9"]


@pytest.mark.parametrize("line", NO_RELATIONS)
def test_a_line_that_is_no_relation_is_named(line: str) -> None:
    with pytest.raises(RelationsError, match="line 2"):
        parse_relations(f"1 2 0 0 0 0 0 0\n{line}\n")


@pytest.mark.parametrize(
    ("argument", "call"),
    [
        ("pairs", lambda: relation_error(np.zeros((2, 3)), [(0, 2)], np.zeros((1, 3)))),
        ("pairs", lambda: relation_error(np.zeros((2, 3)), [(0, -1)], np.zeros((1, 3)))),
        ("pairs", lambda: relation_error(np.zeros((2, 3)), [(0.0, 1.0)], np.zeros((1, 3)))),
        ("pairs", lambda: relation_error(np.zeros((2, 3)), [(0, 1)], np.zeros((2, 3)))),
        ("T_i_j", lambda: relation_error(np.zeros((2, 3)), np.zeros((0, 2), int), np.zeros((0, 3)))),
        ("poses", lambda: relation_error([], [(0, 1)], np.zeros((1, 3)))),
    ],
)
def test_what_has_no_errors_by_relations_is_named(argument: str, call: Any) -> None:
    with pytest.raises(MetricError) as caught:
        call()
    assert caught.value.argument == argument
