"""Stale answers: a program that keeps its results under an incomplete key gives an old one to a call that is new.

A launch is asked a probe, then the same call with one argument changed; another launch is asked the changed call alone.
Where the first gives again what it gave to the probe, and the second something else, the program remembers too much.
Whether the changed arguments are ones that a statement allows does not matter: a program without memory answers a call
alike in both. Asked of programs only whose text shows where they may keep something.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from graders.core.code.checks import Check, Rejection
from graders.core.code.contracts import FunctionContract
from graders.core.code.probe_runs import MEMORY
from graders.core.code.probes import Probes, same_probe_answer
from graders.core.code.runner import Runner
from graders.core.code.running import make_failed_finding
from graders.core.code.stateless import may_change_state
from graders.core.compare.python_values import to_counterexample_value
from graders.core.contract.findings import Finding
from graders.core.contract.program import Answer, PlannedCalls, Reply, StudentFault, flatten_blocks
from graders.core.contract.values import Arguments, Value

#: Seconds for all calls of one launch.
MAX_SECONDS = 2.0
#: Probes of a function whose arguments are changed, and the changes of each argument.
MAX_BASES, MAX_CHANGES = 3, 4


@dataclass(frozen=True)
class ChangedCall:
    """A call, where its base stands in the series, and the index of the argument that is changed: a base is its own.

    `turn` counts the changes of one argument: no two of a turn differ in one argument alone.
    """

    args: Arguments
    base: int
    index: int = 0
    turn: int = 0


@dataclass(frozen=True)
class StaleAnswer:
    """A call that got the answer to another one, where only the argument at `index` was different."""

    function: str
    args: Arguments
    index: int
    fresh: Value
    stale: Value


def fail_checks_with_stale_answers(
    checks: Sequence[Check],
    findings: Sequence[Finding],
    runner: Runner,
    probed: Sequence[Probes],
    contracts: Sequence[FunctionContract],
) -> list[Finding]:
    """Return the findings, where the last check of each function with a stale answer fails if it passes all of them.

    The runner learns which functions these are.
    """
    held = list(findings)
    if runner.reenacting or not may_change_state(runner.source):
        return held
    found = find_stale_answers(runner, probed)
    runner.stale = frozenset(found)
    names = {contract.function: tuple(contract.takes) for contract in contracts}
    for function, stale in found.items():
        places = [k for k, check in enumerate(checks) if function in check.functions]
        if places and all(held[k].passed for k in places):
            place = max(places, key=lambda k: (not checks[k].requires_other_check, k))
            held[place] = make_failed_finding(checks[place], _stale_answer_rejection(stale, names.get(function, ())))
    return held


def find_stale_answers(runner: Runner, probed: Sequence[Probes]) -> Mapping[str, StaleAnswer]:
    """Return a stale answer of each function that gives one, by its name. Functions that draw numbers are not asked."""
    found: dict[str, StaleAnswer] = {}
    steady = [probes for probes in probed if not probes.random and runner.is_callable(probes.function)]
    for _, group in itertools.groupby(steady, key=lambda probes: id(probes.kit)):
        of_kit = list(group)
        asked = [make_changed_calls(probes.calls) for probes in of_kit]
        whole = [list(range(len(series))) for series in asked]
        first = _answer_on_new_launch(runner, of_kit, asked, whole)
        for turn in range(MAX_CHANGES if first else 0):  # each in a launch of its own, without the bases
            places = [
                [k for k in whole[n] if series[k].turn == turn and series[k].base != k]
                for n, series in enumerate(asked)
            ]
            again = _answer_on_new_launch(runner, of_kit, asked, places)
            for n, fresh in enumerate(again):
                stale = _find_stale_answer_in_series(
                    of_kit[n].function, asked[n], first[n], dict(zip(places[n], fresh, strict=False))
                )
                if stale is not None:
                    found.setdefault(stale.function, stale)
    return found


def _stale_answer_rejection(answer: StaleAnswer, known: Sequence[str]) -> Rejection:
    names = [known[k] if k < len(known) else f"argument {k + 1}" for k in range(len(answer.args))]
    return Rejection(
        f"Après un appel où seul {names[answer.index]} était différent, {answer.function} renvoie de nouveau le "
        "résultat de cet appel. Dans un programme relancé, appelée avec ces arguments d’abord, elle renvoie autre "
        "chose : elle garde des résultats d’un appel à l’autre, et les reprend sans regarder cet argument.",
        inputs={name: to_counterexample_value(value) for name, value in zip(names, answer.args, strict=True)},
        expected=to_counterexample_value(answer.fresh),
        got=to_counterexample_value(answer.stale),
        slip=MEMORY,
        sign=(answer.function, MEMORY),
    )


def make_changed_calls(calls: Sequence[Arguments]) -> list[ChangedCall]:
    """Return some of the calls with the most arguments, first to last, each followed by itself with one changed."""
    most = max(map(len, calls), default=0)
    series: list[ChangedCall] = []
    longest = [args for args in calls if len(args) == most]
    for args in longest[:: max(1, (len(longest) - 1) // (MAX_BASES - 1))][:MAX_BASES]:
        base = len(series)
        series.append(ChangedCall(args, base))
        for index in range(most):
            others = _iter_other_values(args[index], [call[index] for call in calls if index < len(call)])
            for turn, value in enumerate(itertools.islice(others, MAX_CHANGES)):
                series.append(ChangedCall((*args[:index], value, *args[index + 1 :]), base, index, turn))
    return series


def _answer_on_new_launch(
    runner: Runner, probed: Sequence[Probes], asked: Sequence[Sequence[ChangedCall]], places: Sequence[Sequence[int]]
) -> Sequence[Sequence[Answer]]:
    """Return the answers of a launch to the calls at these places of the series of each function.

    [] where it dies, meets a limit or takes too long.
    """
    batches = [
        PlannedCalls(probes.function, tuple(series[k].args for k in chosen))
        for probes, series, chosen in zip(probed, asked, places, strict=True)
    ]
    deadline = runner.clock() + MAX_SECONDS
    answers: list[list[Answer]] = [[] for _ in batches]
    try:
        with runner.side_program(probed[0].kit, batches) as program:
            for number, answer in flatten_blocks(program.call_batches(batches)):
                if runner.clock() > deadline or (isinstance(answer, StudentFault) and answer.fatal):
                    return []
                answers[number].append(answer)
    except StudentFault:
        return []
    return answers


def _find_stale_answer_in_series(
    function: str, series: Sequence[ChangedCall], answers: Sequence[Answer], again: Mapping[int, Answer]
) -> StaleAnswer | None:
    """Compare the answers to a series with those of another launch to some of its calls, by their places."""
    for place, fresh in again.items() if len(answers) == len(series) else ():
        changed, old, now = series[place], answers[series[place].base], answers[place]
        if not isinstance(old, Reply) or not isinstance(now, Reply) or not same_probe_answer(now.value, old.value):
            continue
        if isinstance(fresh, StudentFault):
            return StaleAnswer(function, changed.args, changed.index, f"une exception ({fresh.exception})", now.value)
        if not same_probe_answer(fresh.value, old.value):
            return StaleAnswer(function, changed.args, changed.index, fresh.value, now.value)
    return None


def _iter_other_values(value: Any, others: Sequence[Any]) -> Iterator[Any]:
    """Yield other values of an argument: its own with other numbers, then those of other calls like it."""
    yield from _iter_perturbed_values(value)
    yield from (other for other in others if _has_same_type_and_shape(value, other) and not _is_equal(value, other))


def _iter_perturbed_values(value: Any) -> Iterator[Any]:
    if isinstance(value, bool | str) or value is None:
        return
    if isinstance(value, int | np.integer):
        yield from (value + 1, value - 1, -value)
    elif isinstance(value, float | np.floating):
        yield from (1.25 * value + 0.125, 0.5 * value)
    elif isinstance(value, np.ndarray) and value.size and value.dtype.kind == "b":
        for parity in (0, 1):  # a map where every second cell is a wall
            other = value.copy()
            other.flat[parity::2] = False
            yield other
        yield ~value
    elif isinstance(value, np.ndarray) and value.size and value.dtype.kind == "f":
        yield 1.25 * value if value.any() else value + 0.5
        yield 1.02 * value + 0.01
        moved = value.copy()
        moved.flat[-1] += 0.5
        yield moved
    elif isinstance(value, list | tuple) and value:
        for k in reversed(range(len(value))):
            for other in itertools.islice(_iter_perturbed_values(value[k]), 1):
                yield type(value)([*value[:k], other, *value[k + 1 :]])
        yield value[:-1]


def _has_same_type_and_shape(first: Any, second: Any) -> bool:
    if type(first) is not type(second):
        return False
    return not isinstance(first, np.ndarray) or (first.shape == second.shape and first.dtype == second.dtype)


def _is_equal(first: Any, second: Any) -> bool:
    if isinstance(first, np.ndarray):
        return bool(np.array_equal(first, second))
    if isinstance(first, list | tuple):
        return len(first) == len(second) and all(map(_is_equal, first, second))
    return type(first) is type(second) and bool(first == second)
