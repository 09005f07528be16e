"""Which changes of a program mend its answers to probes, number by number, and spoil none."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from graders.core.code.bench import Bench
from graders.core.code.changes import ProgramChange, add_loop_counters
from graders.core.code.checks import Check
from graders.core.code.grading import NO_SHRINKING, CodeGrader
from graders.core.code.loops import ClosedLoop
from graders.core.code.mutants import NO_ANSWER
from graders.core.code.pair_search import OutOfTimeError
from graders.core.code.probes import TOLERANCE, ProbeAnswer, ProbeFault, Probes, same_probe_answer
from graders.core.code.recording import CallRecorder
from graders.core.code.runner import Runner
from graders.core.code.running import run_check
from graders.core.code.variants import VariantCaller
from graders.core.contract.program import Programs
from graders.core.contract.streams import stream
from graders.core.contract.values import Floats, UnreadableError, read_array

#: Probes whose wrong answer selects changes.
MAX_PIVOTS = 3
#: Calls that are recorded of failed checks; wrong ones of these, and right ones, by which changes are screened.
MAX_RECORDED, MAX_OF_CHECKS = 80, 8
#: Changed programs that answer in one exchange, between two looks at the time.
SLICE = 200


@dataclass(frozen=True, eq=False)
class _ScreeningCalls:
    """Calls whose answers screen changes, as probes, and the right answers in each style."""

    probes: Probes
    rights: Sequence[Sequence[ProbeAnswer]]


class ProbeScreen:
    """Screens changed programs, which a `caller` calls, until the time is `spent`.

    `pivots`: for each source that was screened, probes with those of them whose wrong answers selected changes. The
    calls that failed checks make under a `seed` stand for the probes of a function that has no wrong answer to these.
    """

    def __init__(
        self, grader: CodeGrader, programs: Programs, caller: VariantCaller, spent: Callable[[], bool], seed: int
    ) -> None:
        self._grader, self._programs, self._caller, self._spent = grader, programs, caller, spent
        self._seed = seed
        self._drawn_answers: dict[int, list[ProbeAnswer]] = {}
        self.pivots: dict[str, list[tuple[Probes, Sequence[int]]]] = {}

    def select_mending_changes(
        self, source: str, changes: Sequence[ProgramChange], functions: Sequence[str], failed: Sequence[Check] = ()
    ) -> list[ProgramChange]:
        """Return the changes that mend numbers of the answers to probes and spoil none, the most mending first.

        Those that were seen until the time was spent. `failed` are the checks that the source fails.
        """
        gains: dict[int, float] = {}
        with suppress(OutOfTimeError):
            self._measure_gains(source, changes, functions, failed, gains)
        order = sorted(gains, key=lambda number: (-round(gains[number], 6), number))
        return [changes[number] for number in order]

    def _measure_gains(
        self, source: str, changes: Sequence[ProgramChange], functions: Sequence[str], failed: Sequence[Check],
        gains: dict[int, float],
    ) -> None:  # fmt: skip
        prober = self._grader.prober
        pivots = self.pivots[source] = list[tuple[Probes, Sequence[int]]]()
        for index, probes in enumerate(prober.probes if prober else ()):
            if probes.function in functions:
                self._measure_gains_on_calls(
                    source, _ScreeningCalls(probes, self._right_answers(index)), changes, gains
                )
        for function in functions:
            if not any(numbers and probes.function == function for probes, numbers in pivots):
                for questions in self._iter_calls_of_failed_checks(source, function, failed):
                    self._measure_gains_on_calls(source, questions, changes, gains)

    def _measure_gains_on_calls(
        self, source: str, questions: _ScreeningCalls, changes: Sequence[ProgramChange], gains: dict[int, float]
    ) -> None:
        everything = range(len(questions.probes.calls))
        before = self._mark_right_numbers(questions, [add_loop_counters(source)], everything)[0]
        wrong = [k for k in everything if not before[k].all()]
        pivots, left = wrong[:MAX_PIVOTS], range(len(changes)) if wrong else ()
        self.pivots[source].append((questions.probes, pivots))
        for begin in range(0, len(left), SLICE):
            numbers = left[begin : begin + SLICE]
            seen = self._mark_right_numbers(
                questions, [changes[number].text_with_counters for number in numbers], pivots
            )
            hits = [
                number
                for number, marks in zip(numbers, seen, strict=True)
                if any(_is_improvement([before[k]], [after]) for k, after in zip(pivots, marks, strict=True))
            ]
            answers = self._mark_right_numbers(
                questions, [changes[number].text_with_counters for number in hits], everything
            )
            for number, after in zip(hits, answers, strict=True):
                if _is_improvement(before, after):
                    gains[number] = gains.get(number, 0.0) + _count_mended_answers(before, after) / max(1, len(wrong))

    def _iter_calls_of_failed_checks(
        self, source: str, function: str, failed: Sequence[Check]
    ) -> Iterator[_ScreeningCalls]:
        """Yield the calls of a function that failed checks make of the solution: wrong ones, then some right ones."""
        recorder = CallRecorder([function], MAX_RECORDED)
        kit = self._grader.kit(stream(self._seed, "kit"))
        runner = Runner(recorder, self._grader.solution.encode(), kit, budget=NO_SHRINKING)
        try:
            for check in failed:
                if function in check.functions and not isinstance(check, ClosedLoop) and not self._spent():
                    run_check(check, Bench(check.id, runner, stream(self._seed, check.id), kit))
        finally:
            runner.close()
        for side_kit, _, calls in recorder.iter_calls_by_kit():
            asked = Probes(function=function, calls=calls, kit=side_kit)
            right = self._solution_answers(asked)
            marks = self._mark_right_numbers(
                _ScreeningCalls(asked, [right]), [add_loop_counters(source)], range(len(calls))
            )[0]
            wrong = [k for k, mark in enumerate(marks) if not mark.all()][:MAX_OF_CHECKS]
            others = [k for k, mark in enumerate(marks) if mark.all()][:MAX_OF_CHECKS]
            if wrong:
                probes = replace(asked, calls=tuple(calls[k] for k in (*wrong, *others)))
                yield _ScreeningCalls(probes, [[right[k] for k in (*wrong, *others)]])

    def _mark_right_numbers(
        self, questions: _ScreeningCalls, texts: Sequence[str], indices: Sequence[int]
    ) -> list[list[NDArray[np.bool_]]]:
        """Return, for each program and probe among `indices`, which numbers of its answer are right.

        They are those of the style in which most are right.
        """
        probes, rights = questions.probes, questions.rights
        calls = [probes.calls[k] for k in indices]
        draws = list(indices) if probes.random else ()
        agreements = []
        for begin in range(0, len(texts), SLICE):
            if self._spent():
                raise OutOfTimeError
            for answers in self._caller.call_variants(
                texts[begin : begin + SLICE], probes.function, calls, probes.kit, draws
            ):
                read = [probes.read_answer(args, answer) for args, answer in zip(calls, answers, strict=False)]
                read += [NO_ANSWER] * (len(calls) - len(read))
                in_each_style = [
                    [
                        _mark_right_numbers_of_answer(probes, answer, right[k])
                        for k, answer in zip(indices, read, strict=True)
                    ]
                    for right in rights
                ]
                agreements.append(max(in_each_style, key=lambda marks: sum(float(mark.mean()) for mark in marks)))
        return agreements

    def _right_answers(self, index: int) -> Sequence[Sequence[ProbeAnswer]]:
        """Return the right answers to the probes `index`, in each style; those of the same draws where it draws."""
        assert self._grader.prober is not None
        probes = self._grader.prober.probes[index]
        if not probes.random:
            return self._grader.prober.right_answers_by_style(index)
        if index not in self._drawn_answers:
            self._drawn_answers[index] = self._solution_answers(probes)
        return [self._drawn_answers[index]]

    def _solution_answers(self, probes: Probes) -> list[ProbeAnswer]:
        """Return the solution's answers, to the same draws where the function draws."""
        draws = range(len(probes.calls)) if probes.random else ()
        answers = VariantCaller(self._programs).call_variants(
            [add_loop_counters(self._grader.solution)], probes.function, probes.calls, probes.kit, draws
        )[0]
        read = [probes.read_answer(args, answer) for args, answer in zip(probes.calls, answers, strict=False)]
        return [*read, *[NO_ANSWER] * (len(probes.calls) - len(read))]


def _mark_right_numbers_of_answer(probes: Probes, answer: ProbeAnswer, right: ProbeAnswer) -> NDArray[np.bool_]:
    """Return which numbers of an answer are right: one mark where it is not compared number by number."""
    whole = probes.same(answer, right)
    mine, wanted = _flatten_numbers(answer), _flatten_numbers(right)
    if probes.same is not same_probe_answer or wanted is None:
        return np.array([whole])
    if whole or mine is None or mine.size != wanted.size:
        return np.full(max(1, wanted.size), whole)
    return np.asarray(np.abs(mine - wanted) <= TOLERANCE * np.maximum(1.0, np.abs(wanted)))


def _flatten_numbers(value: ProbeAnswer) -> Floats | None:
    """Return the numbers of an answer in one row; None where it holds anything else."""
    if isinstance(value, list | tuple):
        parts = [_flatten_numbers(part) for part in value]
        return np.concatenate(parts) if parts and all(part is not None for part in parts) else None  # type: ignore[arg-type]
    if isinstance(value, ProbeFault | str) or value is None:
        return None
    try:
        return read_array(value).ravel()
    except UnreadableError:
        return None


def _is_improvement(before: Sequence[NDArray[np.bool_]], after: Sequence[NDArray[np.bool_]]) -> bool:
    """Whether more numbers are right, and none is no longer."""
    if any(len(old) != len(new) for old, new in zip(before, after, strict=True)):
        return all(new.all() or not old.any() for old, new in zip(before, after, strict=True)) and any(
            new.all() and not old.all() for old, new in zip(before, after, strict=True)
        )
    return all(bool((new >= old).all()) for old, new in zip(before, after, strict=True)) and any(
        bool(new.sum() > old.sum()) for old, new in zip(before, after, strict=True)
    )


def _count_mended_answers(before: Sequence[NDArray[np.bool_]], after: Sequence[NDArray[np.bool_]]) -> float:
    """Return how many answers are mended; the part of the numbers where one is mended in part."""
    return sum(float(new.mean()) - float(old.mean()) for old, new in zip(before, after, strict=True))
