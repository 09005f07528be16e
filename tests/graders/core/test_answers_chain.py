"""The longest chain of a proof, against all the orders that its dependencies allow."""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache
from itertools import permutations
from string import ascii_lowercase

from hypothesis import given, settings
from hypothesis import strategies as st

from graders.core.answers.chain import find_transitive_predecessors, longest_chain

After = dict[str, tuple[str, ...]]


def common(one: Sequence[str], other: Sequence[str]) -> int:
    """The length of the longest common subsequence."""
    if not one or not other:
        return 0
    if one[0] == other[0]:
        return 1 + common(one[1:], other[1:])
    return max(common(one[1:], other), common(one, other[1:]))


@lru_cache
def allowed(after: tuple[tuple[str, tuple[str, ...]], ...]) -> list[tuple[str, ...]]:
    """Every order in which each name comes after all those that it needs."""
    needs = dict(after)
    return [
        order
        for order in permutations(needs)
        if all(order.index(other) < order.index(name) for name in order for other in needs[name])
    ]


@st.composite
def proofs(draw: st.DrawFn) -> After:
    names = ascii_lowercase[: draw(st.integers(1, 5))]
    return {
        name: tuple(draw(st.lists(st.sampled_from(names[:place]), unique=True))) if place else ()
        for place, name in enumerate(names)
    }


@settings(max_examples=60, deadline=None)
@given(proofs(), st.data())
def test_the_longest_chain_is_what_an_answer_shares_with_the_nearest_right_order(
    after: After, data: st.DataObject
) -> None:
    answer = data.draw(st.lists(st.sampled_from(list(after)), unique=True))
    nearest = max(common(answer, order) for order in allowed(tuple(after.items())))
    assert longest_chain(answer, find_transitive_predecessors(after)) == nearest


@settings(max_examples=40, deadline=None)
@given(proofs(), st.data())
def test_every_right_order_and_every_part_of_it_is_a_chain(after: After, data: st.DataObject) -> None:
    order = data.draw(st.sampled_from(allowed(tuple(after.items()))))
    part = [name for name in order if data.draw(st.booleans())]
    assert longest_chain(part, find_transitive_predecessors(after)) == len(part)


def test_dependencies_hold_across_a_step_that_is_not_there() -> None:
    before = find_transitive_predecessors({"a": (), "b": ("a",), "c": ("b",)})
    assert longest_chain(["c", "a"], before) == 1


def test_the_longest_list_that_a_sheet_may_have_is_quick_in_any_order() -> None:
    line = find_transitive_predecessors(
        {name: (ascii_lowercase[place - 1],) if place else () for place, name in enumerate("abcdefghij")}
    )
    assert longest_chain("jihgfedcba", line) == 1
    free = find_transitive_predecessors(dict.fromkeys(ascii_lowercase, ()))
    assert longest_chain(ascii_lowercase[::-1], free) == 26
