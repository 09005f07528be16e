"""Intervals at whose ends a function given as an argument has other signs: where a bisection may be asked.

An author's function runs behind the walls alone: a small program in place of the solution says its values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from graders.core.declared.doubts import FEWEST, ordered_pairs, single_positional_call
from graders.core.declared.playing import PlayedScenario
from graders.core.declared.scenario_values import FunctionSource, Reference
from graders.core.declared.scenarios import Scenario

_PROGRAM = """def {name}(*given):
    f, a, b = given[{function}], given[{low}], given[{high}]
    return [float(f(a)), float(f(b))]
"""
DOUBT = "Dans vos exemples, {function} change de signe entre {low} et {high}."


@dataclass(frozen=True)
class IntervalBracket:
    """The arguments of a function `name` that are a function and the ends of an interval, by their positions."""

    name: str
    function: int
    low: int
    high: int

    @property
    def end_values_program(self) -> str:
        """A program that gives the values at both ends in place of the answer."""
        return _PROGRAM.format(name=self.name, function=self.function, low=self.low, high=self.high)

    def doubt_text(self, names: Sequence[str]) -> str:
        """Return why the statement may exclude a case without a change of sign, in French."""
        function, low, high = (names[at] for at in (self.function, self.low, self.high))
        return DOUBT.format(function=function, low=low, high=high)


def find_bracket(examples: Sequence[Scenario], names: Sequence[str]) -> IntervalBracket | None:
    """Return the interval of a function that all examples of one call have; `names` are the parameters."""
    calls = [call for call in map(single_positional_call, examples) if call is not None]
    kinds = {(call.callee, len(call.arguments)) for call in calls}
    if len(calls) < max(FEWEST, len(examples)) or len(kinds) > 1 or len(calls[0].arguments) > len(names):
        return None
    columns = list(zip(*(call.arguments for call in calls), strict=True))
    functions = [
        at for at, column in enumerate(columns) if all(isinstance(it, FunctionSource | Reference) for it in column)
    ]
    pair = next(((low, high) for low, high in ordered_pairs(columns) if high == low + 1), None)
    return IntervalBracket(calls[0].callee, functions[0], *pair) if functions and pair else None


def changes_sign(played: PlayedScenario) -> bool:
    """Whether the values at both ends have other signs, or one of them is zero."""
    values = played.values[-1] if played.values and played.fault is None else None
    return isinstance(values, list) and len(values) == 2 and values[0] * values[1] <= 0
