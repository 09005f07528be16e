"""A check on pairs of clouds: each pair is judged by its cost; the simplest failing one is shrunk and drawn."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple, NoReturn

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection, planned_calls_of
from graders.core.code.simplifying import shrink_and_reject
from graders.core.compare.shrinking import shrink_number
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Answer, PlannedCalls, Reply, StudentFault
from graders.core.contract.values import Floats, Value
from graders.l20.kabsch.best import best_of
from graders.l20.kabsch.judge import Assessment, Part, judge
from reference.registration import RigidAlignment

ANY_BEST = "plusieurs rotations conviennent : toute paire (R, t) avec det R = +1 dont la somme des carrés est minimale"
FEWEST_POINTS = 3
DRAWN_WITHIN = 20.0


class Pairing(NamedTuple):
    """Clouds P and Q (n, d), paired by rows. What it gives serves the diagnosis only if `observed`."""

    P: Floats
    Q: Floats
    observed: bool = True

    @property
    def is_whole(self) -> bool:
        """Are all the coordinates whole numbers?"""
        return all(np.array_equal(cloud, np.round(cloud)) for cloud in (self.P, self.Q))


Drawing = Callable[[np.random.Generator], Iterable[Pairing]]


class Question(NamedTuple):
    """A pairing and its answer."""

    pairing: Pairing
    best: RigidAlignment

    @classmethod
    def about(cls, pairing: Pairing) -> Question:
        return cls(pairing, best_of(pairing.P, pairing.Q))


@dataclass(frozen=True)
class Failure:
    """A pairing that a program fails on: the value and its assessment, or the fault."""

    pairing: Pairing
    best: RigidAlignment
    value: Value
    assessment: Assessment | None
    fault: StudentFault | None

    @property
    def stops(self) -> bool:
        """Is it useless to go on?"""
        return self.fault is not None and (self.fault.fatal or self.fault.outcome is Outcome.MISSING_FUNCTION)

    @property
    def kind(self) -> object:
        """What a simpler failure must have in common with this one."""
        if self.fault is not None:
            return self.fault.exception, self.fault.outcome
        return self.assessment and self.assessment.aspect


@dataclass(frozen=True, kw_only=True)
class Alignments(Check):
    """Judge `kabsch`, or a part of what it returns, on every pairing, the simplest first."""

    pairings: Drawing
    part: Part = Part.PAIR

    @property
    def has_unplanned_calls(self) -> bool:
        return False

    def planned_calls(self, bench: Bench) -> Sequence[PlannedCalls]:
        questions = drawn(self.pairings, int(bench.rng.integers(2**62)))
        return [PlannedCalls("kabsch", [(one.pairing.P, one.pairing.Q) for one in questions], context=questions)]

    def run(self, bench: Bench) -> None:
        first: Failure | None = None
        (asked,) = planned_calls_of(self, bench)
        for question in asked.context:
            if bench.runner.reenacting and not question.pairing.observed:
                continue
            failure = failure_on(bench, question, self.part)
            first = first or failure
            if failure is not None and failure.stops:
                break
        if first is not None:
            self._reject(bench, first)

    def _reject(self, bench: Bench, failure: Failure) -> NoReturn:
        if failure.pairing.is_whole or not failure.best.unique:
            raise rejection(failure)

        def judged(question: Question, answer: Answer) -> Failure | None:
            simpler = failure_of(question, answer, self.part)[0]
            return simpler if simpler is not None and simpler.kind == failure.kind else None

        shrink_and_reject(
            bench, "kabsch", failure, Question(failure.pairing, failure.best), simpler_questions, judged, rejection,
            arguments=lambda one: one.pairing[:2], fair=lambda one: one.best.unique, stops=lambda one: one.stops,
        )  # fmt: skip


@lru_cache(maxsize=64)
def drawn(pairings: Drawing, seed: int) -> tuple[Question, ...]:
    """The questions that a seed draws: kept, since a diagnosis asks them of every misconception in turn."""
    return tuple(Question.about(pairing) for pairing in pairings(np.random.default_rng(seed)))


def failure_on(bench: Bench, question: Question, part: Part) -> Failure | None:
    """How `kabsch` fails on one pairing; None when its answer is right."""
    try:
        answer: Answer = Reply(bench.call("kabsch", *question.pairing[:2]))
    except StudentFault as fault:
        answer = fault
    failure, observed = failure_of(question, answer, part)
    if question.pairing.observed:
        bench.observe("kabsch", observed, ok=failure is None, fault=failure.fault if failure else None)
    return failure


def failure_of(question: Question, answer: Answer, part: Part) -> tuple[Failure | None, Value]:
    """How an answer fails, None when it is right; and what is to be written down of it."""
    pairing, best = question
    if isinstance(answer, StudentFault):
        return Failure(pairing, best, None, None, answer), None
    assessment = judge(pairing.P, pairing.Q, best, answer.value, part)
    failure = Failure(pairing, best, answer.value, assessment, None) if assessment.mismatch else None
    return failure, assessment.observed


def rejection(failure: Failure) -> Rejection:
    """A failure as the finding of a check, with its figure."""
    P, Q, _ = failure.pairing
    inputs = {"P": P, "Q": Q}
    expected = (failure.best.R_q_p, failure.best.t_q_p) if failure.best.unique else ANY_BEST
    if failure.fault is not None:
        return fault_rejection(failure.fault, inputs=inputs, expected=expected)
    assert failure.assessment is not None
    assert failure.assessment.mismatch is not None
    mismatch = failure.assessment.mismatch
    return Rejection(
        mismatch.message,
        inputs=inputs,
        expected=expected,
        got=failure.value,
        slip=mismatch.slip,
        cause=mismatch.cause,
        figure=clouds_figure(P, Q, failure.best, failure.assessment),
    )


def clouds_figure(P: Floats, Q: Floats, best: RigidAlignment, assessment: Assessment) -> FigureData:
    """The data of the figure: the clouds, P moved by the best transformation and, when it can be drawn, by theirs."""
    moved = None
    if assessment.R is not None and assessment.t is not None:
        with np.errstate(over="ignore", invalid="ignore"):
            moved = P @ assessment.R.T + assessment.t
        reach = DRAWN_WITHIN * max(1.0, float(np.max(np.abs(P))), float(np.max(np.abs(Q))))
        moved = moved if bool(np.all(np.abs(moved) <= reach)) else None
    expected = P @ best.R_q_p.T + best.t_q_p
    return {"kind": "clouds", "P": P, "Q": Q, "expected": expected, "got": moved, "unique": best.unique}


def simpler_questions(question: Question) -> Iterator[Question]:
    return map(Question.about, simpler_pairings(question.pairing))


def simpler_pairings(pairing: Pairing) -> Iterator[Pairing]:
    """One pair of points fewer, then whole coordinates everywhere, then one simpler coordinate."""
    P, Q, observed = pairing
    n, d = P.shape
    if n > max(FEWEST_POINTS, d + 1):
        for i in reversed(range(n)):
            yield Pairing(np.delete(P, i, axis=0), np.delete(Q, i, axis=0), observed)
    rounded = Pairing(np.round(P) + 0.0, np.round(Q) + 0.0, observed)
    if np.any(rounded.P != P) or np.any(rounded.Q != Q):
        yield rounded
    yield from _one_simpler_coordinate(pairing)


def _one_simpler_coordinate(pairing: Pairing) -> Iterator[Pairing]:
    both = np.stack(pairing[:2])
    for index in np.ndindex(both.shape):
        for candidate in shrink_number(float(both[index])):
            simpler = both.copy()
            simpler[index] = candidate
            yield Pairing(simpler[0], simpler[1], pairing.observed)
