"""Grading: from a launcher and a seed to a verdict, the same for the same seed."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import TYPE_CHECKING

from graders.core.code.bench import Bench, Observation, Runner
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.code.diagnosis import diagnose, hopeless, slip_diagnosis
from graders.core.compare.words import tidy, to_jsonable
from graders.core.contract.findings import Finding, Grading, verdict_of
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, Launcher, StudentFault, local_launcher
from graders.core.contract.streams import stream
from graders.core.contract.verdict import CheckResult, Counterexample, Diagnosis

if TYPE_CHECKING:
    from graders.core.code.exercise import ExerciseGrader, Misconception

FIGURE_ITEMS = 20_000


def grade(grader: ExerciseGrader, launch: Launcher, *, seed: int, version: str) -> Grading:
    """Run every check of the exercise on the program that `launch` starts.

    Whatever the student's program does ends in the verdict; an exception that leaves this function is our own fault.
    """
    started = time.perf_counter()
    kit = grader.kit(stream(seed, "kit"))
    runner = Runner(launch, kit)
    try:
        findings = _run(grader.checks, runner, kit, seed)
    finally:
        runner.close()
    graded = time.perf_counter()
    diagnosis = _diagnosis(grader, findings, runner.observations, kit, seed)
    done = time.perf_counter()
    timings = {"checks_ms": _ms(graded - started), "diagnosis_ms": _ms(done - graded), "total_ms": _ms(done - started)}
    verdict = verdict_of(grader.exercise, version, seed, findings, diagnosis, stdout=runner.stdout, timings=timings)
    figures = {f.result.id: to_jsonable(f.figure, limit=FIGURE_ITEMS) for f in findings if f.figure is not None}
    return Grading(verdict, figures)


def _run(checks: Sequence[Check], runner: Runner, kit: KitSettings, seed: int) -> list[Finding]:
    try:
        _ = runner.program
    except StudentFault as fault:
        return [_finding(check, fault_rejection(fault, inputs=None)) for check in checks]
    findings = [run_check(check, Bench(check.id, runner, stream(seed, check.id), kit)) for check in checks]
    return [_unless_alone(check, finding, checks, findings) for check, finding in zip(checks, findings, strict=True)]


def _unless_alone(check: Check, finding: Finding, checks: Sequence[Check], findings: Sequence[Finding]) -> Finding:
    """Take back the points of a check that any do-nothing function passes, when nothing else was earned."""
    others = [
        f for c, f in zip(checks, findings, strict=True) if c is not check and set(c.functions) & set(check.functions)
    ]
    if not check.needs_another or not finding.passed or any(f.passed for f in others):
        return finding
    message = "Rien à reprocher ici, mais ces points ne comptent qu'à partir d'une autre vérification réussie."
    return _finding(
        check, Rejection(message, inputs={}, expected="une autre vérification réussie", got="aucune pour l'instant")
    )


def run_check(check: Check, bench: Bench) -> Finding:
    """Run one check and put what it found in words."""
    try:
        check.run(bench)
    except Rejection as rejection:
        return _finding(check, rejection)
    except StudentFault as fault:
        inputs = None
        if bench.last_call is not None:
            inputs = {f"argument {i + 1}": value for i, value in enumerate(bench.last_call[1])}
        return _finding(check, fault_rejection(fault, inputs=inputs))
    return Finding(CheckResult(check.id, check.title, True, check.points, check.points))


def _finding(check: Check, rejection: Rejection) -> Finding:
    counterexample = None
    if rejection.inputs is not None:
        inputs = {name: to_jsonable(value) for name, value in rejection.inputs.items()}
        counterexample = Counterexample(inputs, tidy(to_jsonable(rejection.expected)), tidy(to_jsonable(rejection.got)))
    result = CheckResult(
        id=check.id,
        title=check.title,
        passed=False,
        points=0,
        max_points=check.points,
        message=rejection.message,
        counterexample=counterexample,
        hint=check.hint,
        figure=check.id if rejection.figure is not None else None,
    )
    return Finding(result, rejection.cause, rejection.slip, rejection.figure)


def _diagnosis(
    grader: ExerciseGrader,
    findings: Sequence[Finding],
    observations: Sequence[Observation],
    kit: KitSettings,
    seed: int,
) -> Diagnosis | None:
    failed = [finding for finding in findings if not finding.passed]
    if not failed:
        return None

    def replay(misconception: Misconception) -> Sequence[Observation]:
        return observe(grader, misconception, kit, seed, lambda seen: hopeless(observations, misconception, seen))

    named = diagnose(observations, grader.misconceptions, replay)
    judged = (Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT)
    return named or slip_diagnosis([f.slip for f in failed if f.cause in judged and f.result.counterexample])


def observe(
    grader: ExerciseGrader,
    misconception: Misconception,
    kit: KitSettings,
    seed: int,
    enough: Callable[[Sequence[Observation]], bool] = lambda seen: False,
) -> list[Observation]:
    """What a misconception gives on the inputs that a submission with this seed was graded on.

    `enough` says, from what was seen so far, that the checks to come need not be run.
    """
    runner = Runner(local_launcher(misconception.source), kit, replaying=True)
    for check in grader.checks:
        if set(check.functions) & set(misconception.functions) and not enough(runner.observations):
            with suppress(Rejection, StudentFault):  # what it finds is not told: only what it observes counts
                check.run(Bench(check.id, runner, stream(seed, check.id), kit))
    return runner.observations


def rehearse(grader: ExerciseGrader) -> None:
    """Grade the solution and a mistake in this process: what is imported and compiled at first use then is."""
    for source in (grader.solution, *(mistake.source for mistake in grader.misconceptions[:1])):
        grade(grader, local_launcher(source), seed=0, version="")


def _ms(seconds: float) -> float:
    return round(1000.0 * seconds, 3)
