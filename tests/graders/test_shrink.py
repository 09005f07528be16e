"""Shrinking keeps the failure, simplifies, and stops."""

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from graders.core.compare.shrinking import MAX_CALLS, angle_complexity, complexity, shrink, shrink_array, shrink_pose

poses = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-math.pi, math.pi)).map(np.array)


@given(poses)
def test_a_failure_that_never_goes_away_shrinks_to_the_origin(pose: np.ndarray) -> None:
    (found,) = shrink((pose,), (shrink_pose,), lambda args: True)
    assert np.array_equal(found, [0, 0, 0])


@given(poses)
def test_what_was_shrunk_still_fails(pose: np.ndarray) -> None:
    def fails(args: tuple[np.ndarray, ...]) -> bool:
        return bool(args[0][0] + args[0][1] > 3.0)

    if fails((pose,)):
        assert fails(shrink((pose,), (shrink_pose,), fails))


@given(poses)
def test_proposals_are_simpler_and_leave_the_argument_alone(pose: np.ndarray) -> None:
    before = pose.copy()
    for candidate in shrink_pose(pose):
        changed = [i for i in range(3) if candidate[i] != pose[i]]
        assert len(changed) <= 1
        for i in changed:
            measure = angle_complexity if i == 2 else complexity
            assert measure(float(candidate[i])) < measure(float(pose[i]))
    assert np.array_equal(pose, before)


def test_a_stubborn_failure_costs_a_bounded_number_of_calls() -> None:
    calls = []

    def fails(args: tuple[np.ndarray, ...]) -> bool:
        calls.append(args)
        return False

    array = np.random.default_rng(0).normal(size=(20, 20))
    (found,) = shrink((array,), (shrink_array,), fails)
    assert found is array
    assert len(calls) <= MAX_CALLS
