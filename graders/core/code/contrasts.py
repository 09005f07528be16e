"""A failed call beside a near one that comes out right: both are run, and nothing is said of any other call.

A near call teaches nothing where little is left to compute: no iteration, a share of 1, a start outside the map. So
each argument that the right answer to the failed call feels must be felt by the right answer to the near one too. Where
right answers are whole numbers, such as indices, both must be the same: another one depends on other things.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from graders.core.code.seen_facts import (
    FactKind,
    FunctionTrial,
    ReturnedValue,
    SeenFact,
    sentence_subject,
    shown_value_pair,
    value_text,
)
from graders.core.compare.changed_arguments import iter_argument_variations
from graders.core.compare.near_calls import iter_near_calls
from graders.core.compare.series import same
from graders.core.contract.values import Arguments, Floats

#: Failed calls beside which near ones are tried, and the error up to which an answer is the awaited one.
MAX_FAILED, JUST = 2, 1e-8
#: Near calls of a failed one that come out right of which it is looked at what their right answers feel.
MAX_LOOKED_AT = 6
_QUESTION = "Qu’est-ce qui change dans votre calcul, du premier appel au second ?"
#: Answers of a program, and of the solution, to some calls; fewer where the time is spent.
Answers = Sequence[list[Floats] | None]
Ask = Callable[[Sequence[Arguments]], Answers]


def find_contrast(trial: FunctionTrial, views: Sequence[ReturnedValue], run: Ask, solve: Ask) -> SeenFact | None:
    """Return the smallest change of a failed call that makes a wrong value right; None where none of those tried does.

    `run` asks the program, `solve` the solution.

    The failed call is asked again before and after the near ones: a program that draws, or remembers, shows nothing.
    """
    for view in views:
        wrong = [k for k, is_wrong in enumerate(trial.make_series(view).wrong) if is_wrong]
        for number in sorted(wrong, key=trial.count_argument_numbers)[:MAX_FAILED]:
            failed = trial.calls[number]
            near = list(iter_near_calls(trial.names, failed))
            calls = [failed, *(each.call for each in near), failed]
            mine, its = run(calls), solve(calls)
            if len(mine) < len(calls) or len(its) < len(calls) or _are_equal_to_the_digit(view, mine[0], its[0]):
                continue
            if not _are_equal_to_the_digit(view, mine[0], mine[-1]):
                continue
            just = [
                (each, right)
                for each, got, right in zip(near, mine[1:], its[1:], strict=False)
                if right is not None
                and _are_equal_to_the_digit(view, got, right)
                and _is_right_value_unchanged(view, right, its[0])
            ]
            felt = _influential_arguments(trial.names, failed, its[0], view, solve) if just else frozenset()
            for each, right in just[:MAX_LOOKED_AT]:
                if felt <= _influential_arguments(trial.names, each.call, right, view, solve):
                    return _contrast_fact(trial, view, number, each.words, view.read(right))
    return None


def _is_right_value_unchanged(view: ReturnedValue, near: Sequence[Floats], failed: Sequence[Floats] | None) -> bool:
    """Whether two right answers are the same, unless they hold more than whole numbers."""
    if failed is None:
        return False
    first, second = view.read(near), view.read(failed)
    are_whole = all(bool(np.all(value == np.round(value))) for value in (first, second))
    return not are_whole or same(first, second)


def _influential_arguments(
    names: tuple[str, ...], call: Arguments, right: Sequence[Floats] | None, view: ReturnedValue, solve: Ask
) -> frozenset[int]:
    """Return the indices of the arguments of which some variation changes the right answer to a call."""
    varied = [
        (index, other)
        for index, change in iter_argument_variations(names, call)
        if (other := change.apply(call)) is not None
    ]
    answers = solve([other for _, other in varied])
    return frozenset(
        index
        for (index, _), answer in zip(varied, answers, strict=False)
        if answer is not None and right is not None and len(answer) == len(right)
        if not same(view.read(answer), view.read(right))
    )


def _are_equal_to_the_digit(view: ReturnedValue, got: Sequence[Floats] | None, right: Sequence[Floats] | None) -> bool:
    if got is None or right is None or len(got) != len(right):
        return False
    mine, its = view.read(got), view.read(right)
    return mine.shape == its.shape and bool(np.all(np.isfinite(its)) and np.allclose(mine, its, rtol=JUST, atol=JUST))


def _contrast_fact(trial: FunctionTrial, view: ReturnedValue, number: int, words: str, answer: Floats) -> SeenFact:
    series = trial.make_series(view)
    title = f"{sentence_subject(view.words)} est faux pour un appel, et juste pour le même appel mais {words}"
    expected, got = shown_value_pair(series.right[number], series.got[number])
    proof = (
        f"Pour {trial.call_text(trial.calls[number])}, on attend {expected} et on obtient {got}. "
        f"Pour le même appel mais {words}, on attend et on obtient {value_text(answer)}."
    )
    return SeenFact(trial.function, title, proof, _QUESTION, FactKind.CONTRAST)
