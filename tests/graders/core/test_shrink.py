"""Shrinking keeps the failure, simplifies, and stops."""

import math
import time
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from graders.core.compare.search import ShrinkSearch
from graders.core.compare.shrinking import Budget, Shrinker, iter_simpler_arguments, reading_cost, shrink_array
from graders.core.contract.values import Arguments
from graders.robotics.poses import angle_complexity, shrink_pose
from tests.support.reenactments import CALLS_ONLY

poses = st.tuples(st.floats(-50, 50), st.floats(-50, 50), st.floats(-math.pi, math.pi)).map(np.array)


def shrink(
    arguments: Arguments,
    shrinkers: Sequence[Shrinker],
    still_fails: Callable[[Arguments], bool],
    budget: Budget,
    ahead: int = 1,
    clock: Callable[[], float] = time.monotonic,
) -> Arguments:
    """The simplest arguments found on which a program still fails."""
    search: ShrinkSearch[Arguments, bool, Arguments] = ShrinkSearch(
        arguments, arguments, partial(iter_simpler_arguments, shrinkers), lambda args, fails: args if fails else None,
        budget=budget, ahead=ahead, clock=clock,
    )  # fmt: skip
    while asked := search.next_cases():
        search.store_answers([still_fails(one) for one in asked])
    return search.simplest


@given(poses)
def test_a_failure_that_never_goes_away_shrinks_to_the_origin(pose: np.ndarray) -> None:
    (found,) = shrink((pose,), (shrink_pose,), lambda args: True, CALLS_ONLY)
    assert np.array_equal(found, [0, 0, 0])


@given(poses)
def test_what_was_shrunk_still_fails(pose: np.ndarray) -> None:
    def fails(args: tuple[np.ndarray, ...]) -> bool:
        return bool(args[0][0] + args[0][1] > 3.0)

    if fails((pose,)):
        assert fails(shrink((pose,), (shrink_pose,), fails, CALLS_ONLY))


@given(poses)
def test_proposals_are_simpler_and_leave_the_argument_alone(pose: np.ndarray) -> None:
    before = pose.copy()
    for candidate in shrink_pose(pose):
        changed = [i for i in range(3) if candidate[i] != pose[i]]
        assert len(changed) <= 1
        for i in changed:
            measure = angle_complexity if i == 2 else reading_cost
            assert measure(float(candidate[i])) < measure(float(pose[i]))
    assert np.array_equal(pose, before)


def test_a_stubborn_failure_costs_a_bounded_number_of_calls() -> None:
    calls = []

    def fails(args: tuple[np.ndarray, ...]) -> bool:
        calls.append(args)
        return False

    array = np.random.default_rng(0).normal(size=(20, 20))
    (found,) = shrink((array,), (shrink_array,), fails, CALLS_ONLY)
    assert found is array
    assert len(calls) == CALLS_ONLY.calls


def test_shrinking_stops_when_its_time_is_over_and_keeps_what_it_has() -> None:
    now = iter(range(100))
    budget = Budget(seconds=3)
    calls: list[float] = []

    def fails(args: tuple[np.ndarray, ...]) -> bool:
        calls.append(float(args[0][0]))
        return len(calls) == 1

    (found,) = shrink((np.array([2.7]),), (shrink_array,), fails, budget, clock=lambda: float(next(now)))
    assert calls == [3.0, 0.0, 1.0]
    assert np.array_equal(found, [3.0])


@given(poses, poses, st.integers(0, 6), st.floats(-3, 3))
def test_what_is_asked_ahead_changes_nothing_of_what_is_found(
    one: np.ndarray, other: np.ndarray, which: int, least: float
) -> None:
    """Whatever makes an input fail, and whatever was asked that turns out not to be needed."""

    def fails(args: Arguments) -> bool:
        numbers = [*args[0], *args[1]]
        return bool(sum(numbers[k] for k in range(6) if k != which) > least or numbers[which % 6] > 1.2)

    asked: list[int] = []

    def counted(args: Arguments) -> bool:
        asked.append(1)
        return fails(args)

    budget = Budget(calls=30, seconds=math.inf)
    if fails((one, other)):
        shrinkers = (shrink_pose, shrink_pose)
        found = [shrink((one, other), shrinkers, counted, budget, ahead) for ahead in (1, 24)]
        assert np.array_equal(found[0], found[1])
        assert len(asked) <= budget.calls + (2 * budget.calls + 24) + budget.calls


def test_a_search_is_over_where_the_program_answers_no_more() -> None:
    search: ShrinkSearch[float, bool, float] = ShrinkSearch(
        2.5, 2.5, lambda x: iter([x / 2, x / 4]), lambda x, fails: x if fails else None,
        budget=Budget(calls=9, seconds=math.inf), ahead=6,
    )  # fmt: skip
    assert search.next_cases()[0] == 1.25
    search.store_answers([True])
    assert search.next_cases()
    search.store_answers([])
    assert search.next_cases() == []
    assert search.simplest == 1.25
