"""Bug hunts of declared exercises: a known mistake's program, of which one looks for an input that shows it.

An input shows it where a check refuses the wrong program's answer. Both programs run in the sandbox; inputs are read as
data, as the author's cases are.
"""

from __future__ import annotations

import time
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass

import numpy as np

from graders.core.code.hunts import InputFault, InputOutsideStatement
from graders.core.code.student_form import rewrite_as_student_form
from graders.core.compare.python_values import python_text
from graders.core.contract.program import Programs
from graders.core.contract.values import Value
from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.declaration import DeclaredCheck, DeclaredMistake
from graders.core.declared.grading import PROBE_SEED, DeclaredGrader
from graders.core.declared.judging import Case, FailedCase, judge, observed_value
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.playing import Player
from graders.core.declared.scenario_values import FunctionSource, Reference, value_text
from graders.core.declared.scenarios import Scenario, Statement

#: Characters of the longest witness, cases of a check that are tried, and seconds of a search for a simpler one.
MAX_WITNESS, MAX_CASES, SIMPLER_SECONDS = 120, 40, 1.0
KINDS: tuple[tuple[type | tuple[type, ...], str], ...] = (
    (bool, "True ou False"),
    (int, "un entier"),
    (float, "un nombre"),
    (str, "un texte, entre guillemets"),
    ((FunctionSource, Reference), "une fonction, comme lambda x: x + 1"),
    (list, "une liste"),
    (tuple, "un n-uplet"),
    (dict, "un dictionnaire"),
    ((set, frozenset), "un ensemble"),
    (np.ndarray, "un tableau, comme np.array([1.0, 2.0])"),
)


@dataclass(frozen=True)
class HuntedArgument:
    """An argument of the hunted function: its name, and values of it that cases give."""

    name: str
    values: tuple[Value, ...]

    @property
    def description(self) -> str:
        kinds = [words for kind, words in KINDS if any(_is_instance_of_kind(value, kind) for value in self.values)]
        return " ou ".join(kinds) or "une valeur"

    def accepts(self, value: Value) -> bool:
        """Whether a value is of the same type as one that a case gives; an integer is a number."""
        return any(_have_same_type(value, example) for example in self.values)


def _is_instance_of_kind(value: Value, kind: type | tuple[type, ...]) -> bool:
    return isinstance(value, kind) and not (kind is int and isinstance(value, bool))


def _have_same_type(value: Value, example: Value) -> bool:
    if isinstance(example, FunctionSource | Reference):
        return isinstance(value, FunctionSource | Reference)
    if isinstance(value, bool) or isinstance(example, bool) or not isinstance(example, int | float):
        return type(value) is type(example)
    return isinstance(value, int) or (isinstance(value, float) and isinstance(example, float))


@dataclass(frozen=True)
class DeclaredHunt:
    """A known mistake, the function and the check by which it is looked for."""

    grader: DeclaredGrader
    mistake: DeclaredMistake
    check: DeclaredCheck
    function: str
    arguments: tuple[HuntedArgument, ...]

    def wrong_program_source(self, seed: int) -> str:
        """Return the wrong program as a student would write it."""
        return rewrite_as_student_form(self.mistake.program, self.function, seed, public=self.grader.functions)

    def read_input(self, typed: Mapping[str, str]) -> Case:
        """Return the case of typed arguments. Raises InputFault."""
        values = []
        for argument in self.arguments:
            text = typed.get(argument.name, "").strip()
            if not text:
                raise InputFault(argument.name, f"Donnez aussi {argument.name} : {argument.description}.")
            value = _read_value(argument.name, text, self.grader)
            if not argument.accepts(value):
                raise InputFault(argument.name, f"{argument.name} doit être {argument.description}.")
            values.append(value)
        return Case(Scenario((Statement("call", "", self.function, tuple(values)),)))


def _read_value(name: str, text: str, grader: DeclaredGrader) -> Value:
    """Return one typed value, read as data. Raises InputFault."""
    functions = grader.functions
    try:
        (statement,) = parse_scenario(f"{functions[0]}({text}\n)", functions, imports=grader.declaration.imported_names)
    except MalformedDeclaration as error:
        raise InputFault(name, f"{name} : {error.message}.") from error
    except ValueError as error:
        raise InputFault(name, f"{name} : écrivez une seule valeur.") from error
    if statement.callee != functions[0] or len(statement.arguments) != 1 or statement.named:
        raise InputFault(name, f"{name} : écrivez une seule valeur.")
    return statement.arguments[0]


def list_hunts(grader: DeclaredGrader) -> Iterator[DeclaredHunt]:
    """Yield the hunts that an exercise may have: one for each known mistake and check of calls of one function."""
    for mistake in grader.declaration.mistakes:
        for check in grader.declaration.checks:
            cases = [case for case in grader.cases(check, PROBE_SEED)[:MAX_CASES] if _is_one_call(case.scenario)]
            functions = dict.fromkeys(case.scenario.called_program_name for case in cases)
            if check.watched != "value":
                continue
            for function in functions:
                calls = [
                    case.scenario.statements[0].arguments
                    for case in cases
                    if case.scenario.called_program_name == function
                ]
                names = grader.parameters_by_function.get(function, ())
                calls = [call for call in calls if 0 < len(call) == len(names)]
                if calls:
                    columns = zip(names, zip(*calls, strict=True), strict=True)
                    arguments = tuple(HuntedArgument(name, values) for name, values in columns)
                    yield DeclaredHunt(grader, mistake, check, function, arguments)


def _is_one_call(scenario: Scenario) -> bool:
    (first, *others) = scenario.statements
    plain = first.kind == "call" and "." not in first.callee and not (first.named or first.into)
    return plain and not others and not scenario.lines and not scenario.files


@dataclass(frozen=True)
class HuntTrialAnswers:
    """Answers to an input: `expected` and `got` as Python writes them, `fault` where the wrong program stops."""

    shows: bool
    expected: str
    got: str
    fault: str = ""


class DeclaredHuntPrograms:
    """The solution and the wrong program of a hunt, in the sandbox; to be closed."""

    def __init__(self, hunt: DeclaredHunt, programs: Programs) -> None:
        self._hunt, kit = hunt, hunt.grader.kit(PROBE_SEED)
        self._right = Player(programs, hunt.grader.solution.encode(), kit)
        self._wrong = Player(programs, hunt.mistake.program.encode(), kit)

    def close(self) -> None:
        self._right.close()
        self._wrong.close()

    def find_witness(self) -> tuple[str, ...] | None:
        """Return the arguments of a short call that shows the mistake, as one types them; None where none is short."""
        hunt = self._hunt
        cases = [
            case for case in hunt.grader.cases(hunt.check, PROBE_SEED)[:MAX_CASES] if self._calls_hunted_function(case)
        ]
        scenarios = [case.scenario for case in cases]
        answers = zip(cases, self._right.play(scenarios), self._wrong.play(scenarios), strict=True)
        judged = [
            judge(hunt.check, case, right, got)
            for case, right, got in answers
            if right.fault is None and right.raised is None
        ]
        shortest = sorted((each for each in judged if each is not None), key=_call_text_length)[:1]
        simplest = [self._find_simplest(failure) for failure in shortest]
        texts = [tuple(_exact_text(value) for value in each.case.scenario.statements[0].arguments) for each in simplest]
        return next((each for each in texts if sum(map(len, each)) <= MAX_WITNESS), None)

    def _calls_hunted_function(self, case: Case) -> bool:
        return _is_one_call(case.scenario) and case.scenario.called_program_name == self._hunt.function

    def _find_simplest(self, failure: FailedCase) -> FailedCase:
        hunt, until = self._hunt, time.monotonic() + SIMPLER_SECONDS
        return hunt.grader.find_simplest_failure(hunt.check, failure, self._wrong, self._right, time.monotonic, until)

    def try_case(self, case: Case) -> HuntTrialAnswers:
        """Return what an input shows. Raises InputOutsideStatement where the solution gives no value."""
        check = self._hunt.check
        (right,), (got,) = self._right.play([case.scenario]), self._wrong.play([case.scenario])
        if right.fault is not None or right.raised is not None:
            raise InputOutsideStatement
        failure = judge(check, case, right, got)
        expected = python_text(observed_value(check, right, 0))
        if got.fault is not None:
            return HuntTrialAnswers(shows=True, expected=expected, got="", fault=got.fault.message.partition("\n")[0])
        return HuntTrialAnswers(failure is not None, expected, python_text(observed_value(check, got, 0)))


def try_hunt(hunt: DeclaredHunt, programs: Programs, case: Case) -> HuntTrialAnswers:
    """Try one input on both programs. Raises InputOutsideStatement."""
    with closing(DeclaredHuntPrograms(hunt, programs)) as ground:
        return ground.try_case(case)


def _call_text_length(failure: FailedCase) -> int:
    return len(failure.case.scenario.text())


def _exact_text(value: Value) -> str:
    text = value_text(value, None)
    return f"np.{text}" if isinstance(value, np.ndarray) else text
