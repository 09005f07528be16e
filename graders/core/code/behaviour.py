"""Behaviour: what a program answers on inputs that never change for a version of its exercise.

Failures that no misconception names are put together by it: programs that answer the same everywhere make the same
mistake, whoever reads one of them. The inputs are the exercise's probes; what its checks ask of its solution, under a
seed that the version decides, for functions without probes; and those that must be left alone. So no exercise says
anything of its own for it.
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
    call_series,
    modified_arguments,
    read_answers,
    stored_answers,
)
from graders.core.code.checks import Rejection, Untouched
from graders.core.code.grading import CodeGrader
from graders.core.code.probes import read_answer
from graders.core.code.recording import CallRecorder
from graders.core.code.runner import Runner
from graders.core.code.stored_answers import StoredAnswer, same_answer, to_stored, truncate_answers
from graders.core.compare.words import tidy, to_jsonable
from graders.core.contract.local import LocalProgram
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, KitSettings, Programs, Reply, StudentFault
from graders.core.contract.streams import stream
from graders.core.contract.values import Arguments

#: Instead of an answer, of a function that does not give the same one twice.
UNSTABLE = "variable"
MAX_MESSAGE = 400  # characters of what an exception says


@dataclass(frozen=True)
class Example:
    """The input that shows the behaviour best: strict JSON, bounded. `expected` is what a right program answers."""

    function: str
    inputs: dict[str, Any]
    expected: Any
    got: Any

    def to_json(self) -> dict[str, Any]:
        return {"function": self.function, "inputs": self.inputs, "expected": self.expected, "got": self.got}


@dataclass(frozen=True)
class Behaviour:
    """All the answers of a program, in the order of the questions, and which of them are steadily wrong.

    A program whose steady answers are all right tells nothing here of why it failed, nor does one that does not load
    (`loads`). `lacking`: some function that was asked for is not there, which says it all where nothing else is wrong.
    `functions` are those that answer wrongly.
    """

    answers: tuple[StoredAnswer, ...]
    wrong: tuple[int, ...] = ()
    functions: tuple[str, ...] = ()
    is_loadable: bool = True
    lacks_function: bool = False
    example: Example | None = None

    @property
    def shows_mistake(self) -> bool:
        """Does it show what is wrong with the program?"""
        return self.is_loadable and bool(self.wrong)


@dataclass
class _SeriesResult:
    """What one series showed: what came back, and what is looked at of it."""

    answers: list[Answer]
    shown: list[StoredAnswer]


@dataclass(frozen=True)
class _WrongAnswer:
    """An answer that is not right, to call `k`; None of a function that had been stopped."""

    series: CallSeries
    k: int
    answer: Answer | None

    @property
    def args(self) -> Arguments:
        return self.series.calls[self.k]

    @property
    def size(self) -> int:
        return sum(one.size if isinstance(one, np.ndarray) else len(str(to_jsonable(one))) for one in self.args)

    @property
    def raises(self) -> bool:
        return isinstance(self.answer, StudentFault)


class BehaviourObserver:
    """Asks programs of one exercise the questions of its version. Made once; thread-safe."""

    def __init__(self, grader: CodeGrader, version: str) -> None:
        self._grader = grader
        self._seed = int.from_bytes(hashlib.sha256(version.encode()).digest()[:6])
        self._lock = threading.Lock()
        self._free: dict[CallSeries, bool] = {}

    @cached_property
    def series(self) -> tuple[CallSeries, ...]:
        """Those of one kit follow each other."""
        asked = [*self._probed(), *self._recorded()]
        kits = list({id(one.kit): one.kit for one in asked}.values()) or [self._kit]
        asked += self._left_alone(kits[0])
        return tuple(one for kit in kits for one in asked if one.kit is kit)

    @cached_property
    def _kit(self) -> KitSettings:
        return self._grader.kit(stream(self._seed, "kit"))

    def _probed(self) -> Iterator[CallSeries]:
        prober = self._grader.prober
        for index, probes in enumerate(prober.probes if prober else ()):
            yield CallSeries(probes.function, probes.calls, probes.kit, probes.read, index)

    def _recorded(self) -> Iterator[CallSeries]:
        """What the checks ask the solution, of the functions that have no probes."""
        prober = self._grader.prober
        missing = [one for one in self._grader.functions if prober is None or one not in prober.functions]
        if not missing:
            return
        recorder = CallRecorder(missing)
        runner = Runner(recorder, self._grader.solution.encode(), self._kit, reenacting=True)
        with closing(runner):
            for check in self._grader.checks:
                if set(missing) & set(check.functions) and not isinstance(check, Untouched):
                    with suppress(Rejection, StudentFault):
                        check.run(Bench(check.id, runner, stream(self._seed, check.id), self._kit))
        for kit, function, calls in recorder.calls_by_kit():
            yield CallSeries(function, calls, self._kit if kit == self._kit else kit)

    def _left_alone(self, kit: KitSettings) -> Iterator[CallSeries]:
        for check in self._grader.checks:
            if isinstance(check, Untouched):
                for function, args in check.inputs(stream(self._seed, check.id)).items():
                    yield CallSeries(function, (args,), kit, keeping=check.names[function])

    def observe(self, source: bytes, programs: Programs) -> Behaviour:
        """What the program of a file answers. It is launched twice: what it does not answer twice does not count."""
        first = self._round(source, programs, frozenset())
        if first is None:
            return Behaviour((), is_loadable=False)
        stopped = frozenset(
            series.function for series, told in zip(self.series, first, strict=True) if _stopped(told.answers)
        )
        second = self._round(source, programs, stopped)
        if second is None:
            return Behaviour((), is_loadable=False)
        with self._lock:
            return self._behaviour(first, second, stopped)

    def _round(self, source: bytes, programs: Programs, without: Collection[str]) -> list[_SeriesResult] | None:
        """The answers to every series but those of functions that were stopped before; None of what does not load."""
        told = []
        for _, group in itertools.groupby(self.series, key=lambda series: id(series.kit)):
            asked = list(group)
            with closing(Runner(programs, source, asked[0].kit)) as runner:
                try:
                    _ = runner.program
                except StudentFault:
                    return None
                for series in asked:
                    answers = [] if series.function in without else list(call_series(runner, series))
                    told.append(_SeriesResult(answers, stored_answers(series, answers)))
        return told

    def _behaviour(
        self, first: Sequence[_SeriesResult], second: Sequence[_SeriesResult], stopped: Collection[str]
    ) -> Behaviour:
        answers: list[StoredAnswer] = []
        wrong: list[int] = []
        shown: list[_WrongAnswer] = []
        for series, one, other in zip(self.series, first, second, strict=True):
            steady = one.shown if series.function in stopped else _steady(one.shown, other.shown)
            for k in () if _lacks(one.answers) else self._wrong(series, one, steady):
                wrong.append(len(answers) + k)
                shown.append(_WrongAnswer(series, k, one.answers[k] if k < len(one.answers) else None))
            answers += steady
        return Behaviour(
            truncate_answers(answers),
            tuple(wrong),
            tuple(dict.fromkeys(one.series.function for one in shown)),
            lacks_function=any(_lacks(told.answers) for told in first),
            example=self._example(shown),
        )

    def _wrong(self, series: CallSeries, told: _SeriesResult, steady: Sequence[StoredAnswer]) -> list[int]:
        """Which of the steady answers are not right."""
        right = self._right(series, told.answers)
        return [k for k, one in enumerate(steady) if not (same_answer(one, right[k]) or same_answer(one, UNSTABLE))]

    def _right(self, series: CallSeries, answers: Sequence[Answer]) -> Sequence[StoredAnswer]:
        """What a right program answers, of the style of this one where the exercise knows several."""
        if series.keeping:
            return [to_stored("")]
        prober = self._grader.prober
        if series.probes is not None and prober is not None:
            padded = [*read_answers(series, answers), *[STOPPED] * len(series.calls)][: len(series.calls)]
            return [to_stored(one) for one in prober.nearest_right_answers(series.probes, padded)]
        return [to_stored(read_answer(args, self._solved(series, args), series.read)) for args in series.calls]

    def _solved(self, series: CallSeries, args: Arguments) -> Answer:
        """The solution's answer to one call, of a program that has answered no other."""
        try:
            return LocalProgram(self._grader.solution.encode(), series.kit).call(series.function, *args)
        except StudentFault as fault:
            return fault

    def _example(self, wrong: Sequence[_WrongAnswer]) -> Example | None:
        """The smallest input that is answered wrongly; one that is answered rather than one that raises, and one to
        which there is one right answer rather than one to which the solution itself answers otherwise."""
        told = [(self._is_free(one.series), one.raises, one.size, place) for place, one in enumerate(wrong)]
        chosen = [wrong[place] for *_, place in sorted(told) if wrong[place].answer is not None]
        if not chosen:
            return None
        series, answer, args = chosen[0].series, chosen[0].answer, chosen[0].args
        names = _parameters(self._grader.solution, series.function, len(args))
        inputs = {name: to_jsonable(value) for name, value in zip(names, args, strict=True)}
        if isinstance(answer, Reply) and series.keeping:
            at = series.keeping.index(modified_arguments(series, answer)[0])
            return Example(series.function, inputs, to_jsonable(args[at]), to_jsonable((answer.arguments or ())[at]))
        solved = None if self._is_free(series) else self._solved(series, args)
        expected = tidy(to_jsonable(solved.value)) if isinstance(solved, Reply) else None
        got = tidy(to_jsonable(answer.value)) if isinstance(answer, Reply) else str(answer)[:MAX_MESSAGE]
        return Example(series.function, inputs, expected, got)

    def _is_free(self, series: CallSeries) -> bool:
        """Does the solution itself answer otherwise than what is held for right? Several answers are right then."""
        if series not in self._free:
            answers = [] if series.keeping else [self._solved(series, args) for args in series.calls]
            shown = stored_answers(series, answers)
            self._free[series] = not series.keeping and bool(self._wrong(series, _SeriesResult(answers, shown), shown))
        return self._free[series]


def _steady(one: Sequence[StoredAnswer], other: Sequence[StoredAnswer]) -> list[StoredAnswer]:
    return [a if same_answer(a, b) else UNSTABLE for a, b in zip(one, other, strict=True)]


def _stopped(answers: Sequence[Answer]) -> bool:
    return any(isinstance(answer, StudentFault) and answer.fatal for answer in answers)


def _lacks(answers: Sequence[Answer]) -> bool:
    return any(isinstance(answer, StudentFault) and answer.outcome is Outcome.MISSING_FUNCTION for answer in answers)


def _parameters(source: str, function: str, count: int) -> tuple[str, ...]:
    """The names of a function's first parameters, as the solution has them."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef) and node.name == function and len(node.args.args) >= count:
            return tuple(argument.arg for argument in node.args.args[:count])
    return tuple(f"argument {place}" for place in range(1, count + 1))
