"""Why a statement may exclude an input near an author's examples: what all of them have, and it has not."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Iterator, Sequence

from graders.core.compare.python_values import python_text
from graders.core.contract.values import Value
from graders.core.declared.scenario_values import FunctionSource
from graders.core.declared.scenarios import Scenario, Statement

#: Examples from which something is concluded.
FEWEST = 2


def find_doubt(
    scenario: Scenario, examples: Sequence[Scenario], names: Sequence[str], free: Collection[int] = ()
) -> str:
    """Return what every example has and a case has not, in French; empty where nothing is. `names` are the parameters.

    Only cases of one call are looked at: of a class, any order of calls may be right. The sign of arguments at the
    positions `free` does not count.
    """
    call = single_positional_call(scenario)
    columns = None if call is None else _argument_columns_of_like_calls(call, examples)
    if call is None or columns is None:
        return ""
    named = [names[at] if at < len(names) else f"l’argument {at + 1}" for at in range(_argument_count(call))]
    doubts = (
        _iter_order_doubts(call, columns, named, free),
        _iter_function_combination_doubts(call, columns, named),
        _iter_kind_doubts(call, columns, named, free),
    )
    return next(itertools.chain.from_iterable(doubts), "")


def has_other_shape(scenario: Scenario, examples: Sequence[Scenario]) -> bool:
    """Whether a case has lists in a list, or rows of other lengths, where no example has: no such input is meant."""
    call = single_positional_call(scenario)
    columns = None if call is None else _argument_columns_of_like_calls(call, examples)
    if call is None or columns is None:
        return False
    return any(
        all(map(_is_sequence, (value, *column))) and all(map(holds, column)) and not holds(value)
        for value, column in zip(call.arguments, columns, strict=True)
        for holds in (_is_flat_list, _has_rows_of_equal_length)
    )


def _argument_columns_of_like_calls(call: Statement, examples: Sequence[Scenario]) -> list[tuple[Value, ...]] | None:
    """Return each argument's values in the examples that call alike; None where these are too few."""
    others = [other for other in map(single_positional_call, examples) if other is not None]
    alike = [
        other for other in others if other.callee == call.callee and _argument_count(other) == _argument_count(call)
    ]
    return list(zip(*(other.arguments for other in alike), strict=True)) if len(alike) >= FEWEST else None


def _is_flat_list(value: Value) -> bool:
    return not any(map(_is_sequence, value))


def _has_rows_of_equal_length(value: Value) -> bool:
    return len({len(row) if _is_sequence(row) else None for row in value}) < 2


def ordered_pairs(columns: Sequence[Sequence[Value]]) -> Iterator[tuple[int, int]]:
    """Yield the positions of numbers of which the first is less than the second in every example."""
    numbers = [at for at, column in enumerate(columns) if all(map(_is_number, column))]
    for first, second in itertools.permutations(numbers, 2):
        if all(a < b for a, b in zip(columns[first], columns[second], strict=True)):
            yield first, second


def single_positional_call(scenario: Scenario) -> Statement | None:
    """Return the call of a case that is one call by position; None for another case."""
    (first, *others) = scenario.statements
    return None if others or not first.callee or first.named else first


def _argument_count(call: Statement) -> int:
    return len(call.arguments)


def _iter_order_doubts(
    call: Statement, columns: Sequence[Sequence[Value]], names: Sequence[str], free: Collection[int]
) -> Iterator[str]:
    constant = [len({value for value in column if _is_number(value)}) == 1 for column in columns]
    for at, column in enumerate(columns):
        if at not in free and constant[at] and all(map(_is_number, column)) and call.arguments[at] != column[0]:
            yield f"Dans vos exemples, {names[at]} vaut toujours {python_text(column[0])}."
    for first, second in ordered_pairs(columns):
        if (first in free) != (second in free) or (first not in free and (constant[first] or constant[second])):
            continue
        low, high = call.arguments[first], call.arguments[second]
        if _is_number(low) and _is_number(high) and not low < high:
            yield f"Dans vos exemples, {names[first]} est toujours inférieur à {names[second]}."


def _iter_function_combination_doubts(
    call: Statement, columns: Sequence[Sequence[Value]], names: Sequence[str]
) -> Iterator[str]:
    """Yield the functions that no example gives together: of a function and its derivative, both are chosen."""
    functions = [at for at, column in enumerate(columns) if all(isinstance(each, FunctionSource) for each in column)]
    given = [tuple(column[at] for at in functions) for column in zip(*columns, strict=True)]
    if len(functions) > 1 and tuple(call.arguments[at] for at in functions) not in given:
        yield f"Aucun de vos exemples ne donne {' et '.join(names[at] for at in functions)} ensemble ainsi."


def _iter_kind_doubts(
    call: Statement, columns: Sequence[Sequence[Value]], names: Sequence[str], free: Collection[int]
) -> Iterator[str]:
    kinds: tuple[tuple[Callable[[Value], bool], Callable[[Value], bool], str], ...] = (
        (_is_number, lambda value: value >= 0, "n’est jamais négatif"),
        (_is_number, lambda value: value != 0, "n’est jamais nul"),
        (_has_length, lambda value: len(value) > 0, "n’est jamais vide"),
        (_has_rows, lambda value: {len(value)} == {len(row) for row in value}, "est toujours un tableau carré"),
        (_is_list_of_numbers, lambda value: min(value, default=0) >= 0, "n’a jamais de nombre négatif"),
        (_is_text, lambda value: value.lower() == value, "n’a jamais de majuscule"),
        (_is_plain_list, lambda value: sorted(value) == value, "est toujours dans l’ordre croissant"),
    )
    for at, (value, column, name) in enumerate(zip(call.arguments, columns, names, strict=True)):
        if at in free or (_is_number(value) and value == 0 and _has_both_signs(column)):
            continue
        for applies, holds, words in kinds:
            if (
                at not in free
                and applies(value)
                and all(map(applies, column))
                and all(map(holds, column))
                and not holds(value)
            ):
                yield f"Dans vos exemples, {name} {words}."


def _is_number(value: Value) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _has_length(value: Value) -> bool:
    return isinstance(value, str | list | tuple | dict | set)


def _has_both_signs(column: Sequence[Value]) -> bool:
    """Whether zero lies between numbers of the examples."""
    return all(map(_is_number, column)) and min(column) < 0 < max(column)


def _is_sequence(value: Value) -> bool:
    return isinstance(value, list | tuple)


def _has_rows(value: Value) -> bool:
    return isinstance(value, list) and len(value) > 0 and all(map(_is_sequence, value))


def _is_list_of_numbers(value: Value) -> bool:
    return isinstance(value, list) and all(map(_is_number, value))


def _is_text(value: Value) -> bool:
    return isinstance(value, str)


def _is_plain_list(value: Value) -> bool:
    return isinstance(value, list) and (all(map(_is_number, value)) or all(isinstance(item, str) for item in value))
