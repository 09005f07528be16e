"""The inputs on which programs of a trial are tried, and what is proposed of them as a case."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from typing import NamedTuple, TypeVar

from graders.core.compare.python_values import RaisedException, python_text
from graders.core.contract.outcomes import Outcome
from graders.core.contract.values import Value
from graders.core.declared.body_changes import SeenCall, iter_seen_calls
from graders.core.declared.brackets import IntervalBracket, changes_sign, find_bracket
from graders.core.declared.declaration import DeclaredCheck
from graders.core.declared.doubts import find_doubt, has_other_shape
from graders.core.declared.grading import DeclaredGrader
from graders.core.declared.judging import Case, FailedCase, is_answered, observed_value
from graders.core.declared.playing import PlayedScenario
from graders.core.declared.scenarios import Scenario
from graders.core.declared.variations import vary_cases

Item = TypeVar("Item")
TRIAL_SEED = 1
MAX_MESSAGE = 400
#: How a program ends that a limit stopped: no author writes such a case, and its verdict says nothing of the mistake.
LIMITS = frozenset({Outcome.TIMEOUT, Outcome.MEMORY_LIMIT, Outcome.OUTPUT_LIMIT})
#: Inputs near the examples that are played together: one of them may never end.
SCENARIOS_AT_ONCE = 8
#: Plays scenarios on the solution.
Play = Callable[[DeclaredGrader, Sequence[Scenario]], list[PlayedScenario]]


class ProposedCase(NamedTuple):
    """An input by its text, its check, the solution's answer, and why the statement may exclude it."""

    case: str = ""
    check: int = 0
    answer: str = ""
    doubt: str = ""


class TriedInputs:
    """The inputs on which changed programs are tried, with what the solution does: made at the first need.

    `known_cases` are those of the checks, `near_cases` others beside them, which the solution answers: first those that
    have all that the examples have.
    """

    def __init__(self, grader: DeclaredGrader, play: Play, play_near: Play) -> None:
        """`play` plays the known cases on the solution, `play_near` the others, some of which may never end."""
        self._grader, self._play, self._play_near = grader, play, play_near
        self._crossings = frozenset[str]()

    @cached_property
    def known_cases(self) -> list[tuple[int, Case, PlayedScenario]]:
        grader = self._grader
        checks = enumerate(grader.declaration.checks)
        cases = [(at, case) for at, check in checks for case in grader.cases(check, TRIAL_SEED)]
        right = self._play(grader, [case.scenario for _, case in cases])
        return [(at, case, got) for (at, case), got in zip(cases, right, strict=True) if is_answered(got)]

    @property
    def first_raising_input(self) -> tuple[str, str]:
        """A drawn input on which the solution raises an exception of Python, and that exception; empty without one."""
        drawn = ((case, got) for _, case, got in self.known_cases if case.drawn is not None and got.fault is not None)
        return next(((case.scenario.text(), str(got.raised)) for case, got in drawn), ("", ""))

    @cached_property
    def near_cases(self) -> list[tuple[int, Case, PlayedScenario]]:
        grader, _ = self._grader, self.known_cases  # which tells how long a program may take
        checks = enumerate(grader.declaration.checks)
        nearby = [(at, scenario) for at, check in checks for scenario in vary_cases(check, grader.solution)]
        nearby = [(at, scenario) for at, scenario in nearby if not has_other_shape(scenario, self._all_written_cases)]
        if self._interval_bracket is not None:
            self._crossings = self._find_crossings(self._interval_bracket, [scenario for _, scenario in nearby])
        nearby.sort(
            key=lambda pair: bool(self._find_doubt(*pair))
        )  # those may never end: the first that does not is the last
        sure = next((at for at, pair in enumerate(nearby) if self._find_doubt(*pair)), len(nearby))
        played = self._play_near(grader, [scenario for _, scenario in nearby[:sure]])
        for part in split_into_chunks(nearby[sure:]):
            played += self._play_near(grader, [scenario for _, scenario in part])
            if played[-1].fault is not None and played[-1].fault.outcome in LIMITS:
                break
        answered = zip(nearby, played, strict=False)
        return [(at, Case(scenario), got) for (at, scenario), got in answered if got.fault is None and not got.raised]

    @property
    def iter_near_case_chunks(self) -> Iterator[Sequence[tuple[int, Case, PlayedScenario]]]:
        """The near inputs, a few at a time; none is made before it is asked for."""
        yield from split_into_chunks(self.near_cases)

    @property
    def seen_calls(self) -> list[SeenCall]:
        """The calls of the known cases."""
        checks = self._grader.declaration.checks
        return list(iter_seen_calls([(checks[at], case, right) for at, case, right in self.known_cases]))

    @property
    def printed_texts(self) -> list[str]:
        """What the solution displays in the known cases."""
        return [right.printed for _, _, right in self.known_cases]

    def describe_case(self, at: int, case: Case, right: PlayedScenario) -> ProposedCase:
        check, scenario = self._grader.declaration.checks[at], case.scenario
        answer = answer_text(check, scenario, right)
        return ProposedCase(scenario.exact_text() or "", at, answer, self._find_doubt(at, scenario))

    @cached_property
    def _all_written_cases(self) -> list[Scenario]:
        return [case for check in self._grader.declaration.checks for case in check.cases]

    @cached_property
    def _interval_bracket(self) -> IntervalBracket | None:
        """The interval at whose ends a function has other signs in every example."""
        callee = self._all_written_cases[0].statements[0].callee if self._all_written_cases else ""
        bracket = find_bracket(self._all_written_cases, self._grader.parameters_by_function.get(callee, ()))
        found = bracket and self._find_crossings(bracket, self._all_written_cases)
        return bracket if found and all(case.text() in found for case in self._all_written_cases) else None

    def _find_crossings(self, bracket: IntervalBracket, scenarios: Sequence[Scenario]) -> frozenset[str]:
        """Return the scenarios, by their texts, in which the function changes sign."""
        grader = replace(
            self._grader, declaration=replace(self._grader.declaration, solution=bracket.end_values_program)
        )
        called = [scenario for scenario in scenarios if scenario.statements[0].callee == bracket.name]
        played = [
            (scenario, got)
            for part in split_into_chunks(called)
            for scenario, got in zip(part, self._play_near(grader, part), strict=True)
        ]
        return frozenset(scenario.text() for scenario, got in played if changes_sign(got))

    def _find_doubt(self, at: int, scenario: Scenario) -> str:
        names, bracket = (
            self._grader.parameters_by_function.get(scenario.statements[0].callee, ()),
            self._interval_bracket,
        )
        if bracket is None or scenario.statements[0].callee != bracket.name:
            return find_doubt(scenario, self._all_written_cases, names)
        doubt = find_doubt(scenario, self._all_written_cases, names, free=(bracket.low, bracket.high))
        return doubt or ("" if scenario.text() in self._crossings else bracket.doubt_text(names))


def split_into_chunks(items: Sequence[Item]) -> Iterator[Sequence[Item]]:
    """Yield a few items at a time."""
    return (items[start : start + SCENARIOS_AT_ONCE] for start in range(0, len(items), SCENARIOS_AT_ONCE))


def fails_within_limits(failure: FailedCase | None) -> bool:
    """Whether there is a failure, and no limit (time, memory, output) alone caused it: a case worth proposing."""
    return failure is not None and not (failure.got.fault is not None and failure.got.fault.outcome in LIMITS)


def answer_text(check: DeclaredCheck, scenario: Scenario, got: PlayedScenario) -> str:
    return given_value_text(observed_value(check, got, len(scenario.statements) - 1))


def given_value_text(given: Value) -> str:
    return (str(given) if isinstance(given, RaisedException) else python_text(given, None))[:MAX_MESSAGE]
