"""Inputs near those of an author's cases, by which a changed solution may be told from the solution."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import replace

from graders.core.contract.streams import stream
from graders.core.contract.values import Value
from graders.core.declared.declaration import DeclaredCheck
from graders.core.declared.scenarios import Scenario, Statement

#: Inputs of one check, and the seed of those that are drawn.
MAX_VARIATIONS, VARIATION_SEED = 80, 1000


def vary_cases(check: DeclaredCheck) -> list[Scenario]:
    """Return cases beside those of a check: other drawn ones, then the written ones with one argument changed.

    The first change of each written case comes before the second one of any.
    """
    drawn = check.drawn.draw(stream(VARIATION_SEED, check.id)) if check.drawn else ()
    seen = {case.text() for case in check.cases}
    ranks = itertools.zip_longest(*map(_vary, check.cases))
    changed = (scenario for rank in ranks for scenario in rank if scenario is not None)
    chosen: dict[str, Scenario] = {}
    for scenario in itertools.islice(itertools.chain((each.scenario for each in drawn), changed), 4 * MAX_VARIATIONS):
        if scenario.text() not in seen and len(chosen) < MAX_VARIATIONS:
            chosen.setdefault(scenario.text(), scenario)
    return list(chosen.values())


def _vary(case: Scenario) -> Iterator[Scenario]:
    """Yield a case with one call repeated or left out, then with one argument changed."""
    for statements in _other_calls(case.statements):
        yield replace(case, statements=statements, expected=())
    for at, statement in enumerate(case.statements):
        if statement.callee:
            for changed in _vary_call(statement):
                statements = (*case.statements[:at], changed, *case.statements[at + 1 :])
                yield replace(case, statements=statements, expected=())


def _other_calls(statements: tuple[Statement, ...]) -> Iterator[tuple[Statement, ...]]:
    """Yield the calls of a case with one more, or one less: of an object, what was done before counts."""
    calls = [at for at, each in enumerate(statements) if at and each.kind == "call" and not each.into]
    for at in calls:
        other = next(_vary_call(statements[at]), statements[at])
        yield (*statements[: at + 1], other, *statements[at + 1 :])
    for at in calls:
        left = (*statements[:at], *statements[at + 1 :])
        if left[-1].is_shown:
            yield left


def _vary_call(call: Statement) -> Iterator[Statement]:
    for at, value in enumerate(call.arguments):
        for other in vary_value(value):
            yield replace(call, arguments=(*call.arguments[:at], other, *call.arguments[at + 1 :]))


def vary_value(value: Value) -> Iterator[Value]:
    """Yield values near a value, of its type."""
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield from dict.fromkeys((value + 1, value - 1, 2 * value, 0, 1, -value))
    elif isinstance(value, float):
        yield from (value + 0.5, -value, 0.0, value / 3)
    elif isinstance(value, str):
        if value.strip().lstrip("-").isdecimal():
            yield from map(str, vary_value(int(value)))
        yield from (f"{value} {value}", value[::-1], value[:1], f" {value}", f"{value} ", value.upper(), "", value * 2)
        yield from ("a", "a b", "ab a b", "Aa1")
    elif isinstance(value, list):
        yield from (value + value, value[::-1], value[:1], value[1:], [])
        if all(type(item) in (int, float) for item in value):
            yield [-item for item in value]  # numbers of one sign hide what is wrong of the other
        yield [*value, *value[:1]]
        if value:
            yield from ([first, *value[1:]] for first in itertools.islice(vary_value(value[0]), 3))
        else:
            yield from ([1], [3, 1, 2, 1], [0.5, -1.0], ["a", "b", "a"], [[1, 2], [3, 4]])
