"""Behaviour: the answers of a program on inputs that are fixed for a version of its exercise.

It groups the failures that no misconception names: programs with equal answers make the same mistake. The inputs are
the exercise's probes; for functions without probes, the calls that its checks make of the solution under a seed derived
from the version; and the arguments that must stay unmodified. No exercise defines anything of its own for it.
"""

from __future__ import annotations

import ast
import hashlib
import itertools
import threading
from collections.abc import Collection, Iterator, Sequence
from contextlib import closing, suppress
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.call_series import (
    STOPPED,
    CallSeries,
    modified_argument_names,
    read_compared_parts,
    run_call_series,
    stored_answers,
)
from graders.core.code.checks import Rejection, Untouched
from graders.core.code.grading import CodeGrader
from graders.core.code.probes import read_compared_part
from graders.core.code.recording import CallRecorder
from graders.core.code.runner import Runner
from graders.core.code.stored_answers import StoredAnswer, same_answer, to_stored_answer, truncate_answers
from graders.core.compare.words import remove_rounding_noise, to_jsonable
from graders.core.contract.local import LocalProgram
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, KitSettings, Programs, Reply, StudentFault
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments
from graders.core.syntax_trees import parse_source

#: Stands for the answer of a function that answers two launches differently.
UNSTABLE = "variable"
MAX_MESSAGE = 400  # characters of an exception's message


@dataclass(frozen=True)
class Example:
    """The input that shows the behaviour best, in bounded strict JSON; `expected` is the right answer."""

    function: str
    inputs: dict[str, Any]
    expected: Any
    got: Any

    def to_json(self) -> dict[str, Any]:
        return {"function": self.function, "inputs": self.inputs, "expected": self.expected, "got": self.got}


@dataclass(frozen=True)
class Behaviour:
    """All answers of a program in the order of the calls, and the indices of those that are wrong in both launches.

    A program whose stable answers are all right, or that does not load, shows no mistake here. `functions` are those
    that answer wrongly; `lacks_function` tells that a requested one is not defined.
    """

    answers: tuple[StoredAnswer, ...]
    wrong: tuple[int, ...] = ()
    functions: tuple[str, ...] = ()
    is_loadable: bool = True
    lacks_function: bool = False
    example: Example | None = None

    @property
    def shows_mistake(self) -> bool:
        """Whether it shows a mistake of the program."""
        return self.is_loadable and bool(self.wrong)


@dataclass
class _SeriesAnswers:
    """The answers to one series of calls, and the part of them that is compared."""

    answers: list[Answer]
    shown: list[StoredAnswer]


@dataclass(frozen=True)
class _WrongAnswer:
    """A wrong answer to call `k`; None where the function had been stopped before."""

    series: CallSeries
    k: int
    answer: Answer | None

    @property
    def args(self) -> Arguments:
        return self.series.calls[self.k]

    @property
    def size(self) -> int:
        return sum(arg.size if isinstance(arg, np.ndarray) else len(str(to_jsonable(arg))) for arg in self.args)

    @property
    def raises(self) -> bool:
        return isinstance(self.answer, StudentFault)


class BehaviourObserver:
    """Observes the behaviour of programs of one version of an exercise. Thread-safe."""

    def __init__(self, grader: CodeGrader, version: str) -> None:
        self._grader = grader
        self._seed = int.from_bytes(hashlib.sha256(version.encode()).digest()[:6])
        self._lock = threading.Lock()
        self._free: dict[CallSeries, bool] = {}

    @cached_property
    def all_series(self) -> tuple[CallSeries, ...]:
        """All series of calls, grouped by kit."""
        all_series = [*self._iter_probe_series(), *self._iter_recorded_series()]
        kits = list({id(series.kit): series.kit for series in all_series}.values()) or [self._kit_settings]
        all_series += self._iter_unmodified_argument_series(kits[0])
        return tuple(series for kit in kits for series in all_series if series.kit is kit)

    @cached_property
    def _kit_settings(self) -> KitSettings:
        return self._grader.kit(stream(self._seed, "kit"))

    def _iter_probe_series(self) -> Iterator[CallSeries]:
        prober = self._grader.prober
        for index, probes in enumerate(prober.probes if prober else ()):
            yield CallSeries(probes.function, probes.calls, probes.kit, probes.read, index)

    def _iter_recorded_series(self) -> Iterator[CallSeries]:
        """Yield the calls that the checks make of the solution, for functions without probes."""
        prober = self._grader.prober
        missing = [
            function for function in self._grader.functions if prober is None or function not in prober.probed_functions
        ]
        if not missing:
            return
        recorder = CallRecorder(missing)
        runner = Runner(recorder, self._grader.solution.encode(), self._kit_settings, reenacting=True)
        with closing(runner):
            for check in self._grader.checks:
                if set(missing) & set(check.functions) and not isinstance(check, Untouched):
                    with suppress(Rejection, StudentFault):
                        check.run(Bench(check.id, runner, stream(self._seed, check.id), self._kit_settings))
        for kit, function, calls in recorder.iter_calls_by_kit():
            yield CallSeries(function, calls, self._kit_settings if kit == self._kit_settings else kit)

    def _iter_unmodified_argument_series(self, kit: KitSettings) -> Iterator[CallSeries]:
        for check in self._grader.checks:
            if isinstance(check, Untouched):
                for function, args in check.inputs(stream(self._seed, check.id)).items():
                    yield CallSeries(function, (args,), kit, preserved_arguments=check.names[function])

    def observe(self, source: bytes, programs: Programs) -> Behaviour:
        """Return the behaviour of a file's program. It is launched twice; unstable answers do not count."""
        first = self._answer_all_series(source, programs, frozenset())
        if first is None:
            return Behaviour((), is_loadable=False)
        stopped = frozenset(
            series.function
            for series, result in zip(self.all_series, first, strict=True)
            if _has_fatal_fault(result.answers)
        )
        second = self._answer_all_series(source, programs, stopped)
        if second is None:
            return Behaviour((), is_loadable=False)
        with self._lock:
            return self._compare_launches(first, second, stopped)

    def _answer_all_series(
        self, source: bytes, programs: Programs, without: Collection[str]
    ) -> list[_SeriesAnswers] | None:
        """Launch the program and answer every series, without the functions `without`; None if it does not load."""
        results = []
        for _, group in itertools.groupby(self.all_series, key=lambda series: id(series.kit)):
            group_series = list(group)
            with closing(Runner(programs, source, group_series[0].kit)) as runner:
                try:
                    _ = runner.program
                except StudentFault:
                    return None
                for series in group_series:
                    answers = [] if series.function in without else list(run_call_series(runner, series))
                    results.append(_SeriesAnswers(answers, stored_answers(series, answers)))
        return results

    def _compare_launches(
        self, first: Sequence[_SeriesAnswers], second: Sequence[_SeriesAnswers], stopped: Collection[str]
    ) -> Behaviour:
        answers: list[StoredAnswer] = []
        wrong: list[int] = []
        wrong_answers: list[_WrongAnswer] = []
        for series, result, repeated in zip(self.all_series, first, second, strict=True):
            steady = (
                result.shown if series.function in stopped else _mark_unstable_answers(result.shown, repeated.shown)
            )
            for k in () if _lacks_function(result.answers) else self._wrong_answer_indices(series, result, steady):
                wrong.append(len(answers) + k)
                wrong_answers.append(_WrongAnswer(series, k, result.answers[k] if k < len(result.answers) else None))
            answers += steady
        return Behaviour(
            truncate_answers(answers),
            tuple(wrong),
            tuple(dict.fromkeys(result.series.function for result in wrong_answers)),
            lacks_function=any(_lacks_function(result.answers) for result in first),
            example=self._choose_example(wrong_answers),
        )

    def _wrong_answer_indices(
        self, series: CallSeries, result: _SeriesAnswers, steady: Sequence[StoredAnswer]
    ) -> list[int]:
        """Return the indices of the stable answers that are wrong."""
        right = self._right_answers(series, result.answers)
        return [
            k for k, answer in enumerate(steady) if not (same_answer(answer, right[k]) or same_answer(answer, UNSTABLE))
        ]

    def _right_answers(self, series: CallSeries, answers: Sequence[Answer]) -> Sequence[StoredAnswer]:
        """Return the right answers, in the style of this program where the exercise knows several."""
        if series.preserved_arguments:
            return [to_stored_answer("")]
        prober = self._grader.prober
        if series.probes is not None and prober is not None:
            padded = [*read_compared_parts(series, answers), *[STOPPED] * len(series.calls)][: len(series.calls)]
            return [
                to_stored_answer(right_answer) for right_answer in prober.nearest_right_answers(series.probes, padded)
            ]
        return [
            to_stored_answer(read_compared_part(args, self._solution_answer(series, args), series.read))
            for args in series.calls
        ]

    def _solution_answer(self, series: CallSeries, args: Arguments) -> Answer:
        """Return the solution's answer to one call, from a fresh launch."""
        try:
            return LocalProgram(self._grader.solution.encode(), series.kit).call(series.function, *args)
        except StudentFault as fault:
            return fault

    def _choose_example(self, wrong: Sequence[_WrongAnswer]) -> Example | None:
        """Return the smallest wrong input, preferably with a unique right answer and without an exception."""
        ranked = [
            (self._has_several_right_answers(wrong_answer.series), wrong_answer.raises, wrong_answer.size, index)
            for index, wrong_answer in enumerate(wrong)
        ]
        chosen = [wrong[index] for *_, index in sorted(ranked) if wrong[index].answer is not None]
        if not chosen:
            return None
        series, answer, args = chosen[0].series, chosen[0].answer, chosen[0].args
        names = _parameter_names(self._grader.solution, series.function, len(args))
        inputs = {name: to_jsonable(value) for name, value in zip(names, args, strict=True)}
        if isinstance(answer, Reply) and series.preserved_arguments:
            at = series.preserved_arguments.index(modified_argument_names(series, answer)[0])
            return Example(series.function, inputs, to_jsonable(args[at]), to_jsonable((answer.arguments or ())[at]))
        solved = None if self._has_several_right_answers(series) else self._solution_answer(series, args)
        expected = remove_rounding_noise(to_jsonable(solved.value)) if isinstance(solved, Reply) else None
        got = (
            remove_rounding_noise(to_jsonable(answer.value)) if isinstance(answer, Reply) else str(answer)[:MAX_MESSAGE]
        )
        return Example(series.function, inputs, expected, got)

    def _has_several_right_answers(self, series: CallSeries) -> bool:
        """Whether several answers are right, so that the solution itself may differ from the model."""
        if series not in self._free:
            answers = (
                [] if series.preserved_arguments else [self._solution_answer(series, args) for args in series.calls]
            )
            stored = stored_answers(series, answers)
            self._free[series] = not series.preserved_arguments and bool(
                self._wrong_answer_indices(series, _SeriesAnswers(answers, stored), stored)
            )
        return self._free[series]


def _mark_unstable_answers(first: Sequence[StoredAnswer], second: Sequence[StoredAnswer]) -> list[StoredAnswer]:
    return [a if same_answer(a, b) else UNSTABLE for a, b in zip(first, second, strict=True)]


def _has_fatal_fault(answers: Sequence[Answer]) -> bool:
    return any(isinstance(answer, StudentFault) and answer.fatal for answer in answers)


def _lacks_function(answers: Sequence[Answer]) -> bool:
    return any(isinstance(answer, StudentFault) and answer.outcome is Outcome.MISSING_FUNCTION for answer in answers)


def _parameter_names(source: str, function: str, count: int) -> tuple[str, ...]:
    """Return the names of the first parameters of a function in a source."""
    for node in ast.walk(parse_source(source)):
        if isinstance(node, ast.FunctionDef) and node.name == function and len(node.args.args) >= count:
            return tuple(argument.arg for argument in node.args.args[:count])
    return tuple(f"argument {number}" for number in range(1, count + 1))
