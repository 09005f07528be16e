"""Why a statement may exclude an input near an author's examples: what all of them have, and it has not."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Sequence

from graders.core.compare.python_values import python_text
from graders.core.contract.values import Value
from graders.core.declared.scenarios import Scenario, Statement

#: Examples from which something is concluded.
FEWEST = 2


def find_doubt(scenario: Scenario, examples: Sequence[Scenario], names: Sequence[str]) -> str:
    """Return what every example has and a case has not, in French; empty where nothing is. `names` are the parameters.

    Only cases of one call are looked at: of a class, any order of calls may be right.
    """
    call = _only_call(scenario)
    calls = [each for each in map(_only_call, examples) if each is not None and call is not None]
    alike = [each for each in calls if call and each.callee == call.callee and _width(each) == _width(call)]
    if call is None or len(alike) < FEWEST:
        return ""
    named = [names[at] if at < len(names) else f"l’argument {at + 1}" for at in range(_width(call))]
    columns = list(zip(*(each.arguments for each in alike), strict=True))
    return next(itertools.chain(_order(call, columns, named), _kind(call, columns, named)), "")


def ordered_pairs(columns: Sequence[Sequence[Value]]) -> Iterator[tuple[int, int]]:
    """Yield the positions of numbers of which the first is less than the second in every example."""
    numbers = [at for at, column in enumerate(columns) if all(map(_is_number, column))]
    for first, second in itertools.permutations(numbers, 2):
        if all(a < b for a, b in zip(columns[first], columns[second], strict=True)):
            yield first, second


def _only_call(scenario: Scenario) -> Statement | None:
    (first, *others) = scenario.statements
    return None if others or not first.callee or first.named else first


def _width(call: Statement) -> int:
    return len(call.arguments)


def _order(call: Statement, columns: Sequence[Sequence[Value]], names: Sequence[str]) -> Iterator[str]:
    constant = [len({value for value in column if _is_number(value)}) == 1 for column in columns]
    for at, column in enumerate(columns):
        if constant[at] and all(map(_is_number, column)) and call.arguments[at] != column[0]:
            yield f"Dans vos exemples, {names[at]} vaut toujours {python_text(column[0])}."
    for first, second in ordered_pairs(columns):
        if constant[first] or constant[second]:
            continue
        low, high = call.arguments[first], call.arguments[second]
        if _is_number(low) and _is_number(high) and not low < high:
            yield f"Dans vos exemples, {names[first]} est toujours inférieur à {names[second]}."


def _kind(call: Statement, columns: Sequence[Sequence[Value]], names: Sequence[str]) -> Iterator[str]:
    kinds: tuple[tuple[Callable[[Value], bool], Callable[[Value], bool], str], ...] = (
        (_is_number, lambda value: value >= 0, "n’est jamais négatif"),
        (_is_number, lambda value: value != 0, "n’est jamais nul"),
        (_has_length, lambda value: len(value) > 0, "n’est jamais vide"),
        (_is_text, lambda value: value.lower() == value, "n’a jamais de majuscule"),
        (_is_plain_list, lambda value: sorted(value) == value, "est toujours dans l’ordre croissant"),
    )
    for value, column, name in zip(call.arguments, columns, names, strict=True):
        for applies, holds, words in kinds:
            if applies(value) and all(map(applies, column)) and all(map(holds, column)) and not holds(value):
                yield f"Dans vos exemples, {name} {words}."


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _has_length(value: Value) -> bool:
    return isinstance(value, str | list | tuple | dict | set)


def _is_text(value: Value) -> bool:
    return isinstance(value, str)


def _is_plain_list(value: Value) -> bool:
    return isinstance(value, list) and (all(map(_is_number, value)) or all(isinstance(item, str) for item in value))
