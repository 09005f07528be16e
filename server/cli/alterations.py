"""`balise check --mutants [EXERCISE…]`: mutation testing of an exercise's checks.

Each solution is altered at one place in every way that `graders.core.alterations` knows, and each altered program is
graded in the sandbox until a check fails. A program that no check fails on any seed has survived: its diff is printed.
Programs that are still right are marked by hand in the exercise's `equivalents.toml`; a mark of an alteration that is
gone, or that a check fails, is a fault.
"""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from enum import Enum
from functools import cache
from itertools import islice

from graders.core.alterations.alterations import Alteration, find_alterations
from graders.core.alterations.equivalents import EquivalentMark, find_stale_marks, read_equivalents
from graders.core.code.checks import Check
from graders.core.code.grading import CodeGrader
from graders.core.contract.malformed import MalformedExerciseError
from server.cli import CommandError, parallel
from server.client.program.report import format_number
from server.course import Course, Exercise
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Policy

log = logging.getLogger(__name__)

#: The first seed, and those on which a surviving program is tried again: the same at each run.
SEEDS = (2026, 2027, 2028)
#: The shares that must be caught, of all alterations and of the course's own.
GOAL, GOAL_OF_OUR_OWN = 0.97, 1.0
#: An altered program that computes for so many times what the solution takes, and so many seconds at least, is stopped.
SLOWDOWN_LIMIT, MIN_SECONDS = 10.0, 1.0
#: Number of tries of a grading that fails for a reason of ours.
TRIES = 2


class MutantStatus(Enum):
    """The result of an altered program."""

    CAUGHT = "tuée"
    BY_CHANCE = "tuée selon la graine"
    SURVIVED = "survit"
    EQUIVALENT = "équivalente"
    MISMARKED = "marquée équivalente, mais refusée"
    BROKEN = "correction échouée"


@dataclass(frozen=True)
class MutantTrial:
    """An alteration and its result; `detail` is the check that caught it, or our own error."""

    alteration: Alteration
    fate: MutantStatus
    detail: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class MutantTally:
    """The results of an exercise's alterations; `faults` are those of its marks, or of its solution."""

    exercise: str
    trials: Sequence[MutantTrial]
    faults: Sequence[str]

    def trials_with(self, *fates: MutantStatus, own: bool = False) -> list[MutantTrial]:
        return [
            trial for trial in self.trials if trial.fate in fates and (trial.alteration.is_course_mistake or not own)
        ]

    def count_caught(self, *, own: bool = False) -> tuple[int, int]:
        """Return how many were caught, of how many that are not equivalent."""
        caught = len(self.trials_with(MutantStatus.CAUGHT, MutantStatus.BY_CHANCE, own=own))
        return caught, caught + len(self.trials_with(MutantStatus.SURVIVED, own=own))

    @property
    def is_goal_reached(self) -> bool:
        """Whether the goal is reached, without any fault."""
        reached = all(
            _fraction(*self.count_caught(own=own)) >= goal for own, goal in ((False, GOAL), (True, GOAL_OF_OUR_OWN))
        )
        return reached and not self.faults and not self.trials_with(MutantStatus.MISMARKED, MutantStatus.BROKEN)


def _fraction(part: int, total: int) -> float:
    return part / total if total else 1.0


@dataclass(frozen=True, eq=False)
class MutationSubject:
    """An exercise whose solution is altered: its checks, the cheapest first, under a shortened policy."""

    exercise: Exercise
    code: CodeGrader
    checks: tuple[Check, ...]
    policy: Policy
    marks: Sequence[EquivalentMark]

    def find_catching_check(self, grader: SandboxGrader, source: str, seed: int) -> str | None:
        """Return the check that catches a program. An exception raised twice in a row is our own failure."""
        for _ in range(TRIES - 1):
            try:
                return self._find_catching_check_once(grader, source, seed)
            except Exception:
                log.exception("an altered %s could not be graded with seed %d", self.exercise.id, seed)
        return self._find_catching_check_once(grader, source, seed)

    def _find_catching_check_once(self, grader: SandboxGrader, source: str, seed: int) -> str | None:
        programs = grader.program_starter(self.exercise.id, self.policy)
        return self.code.first_failed_check(source.encode(), programs, seed=seed, checks=self.checks)


def run(course: Course, selected: Sequence[Exercise]) -> int:
    """Try and report; return 1 below the goal or where a mark is wrong. Without `selected`, all exercises of code.

    Raises CommandError for a selected exercise without code, and for unreadable marks.
    """
    subjects = [
        load_subject(exercise) for exercise in selected or course.exercises.values() if selected or _has_code(exercise)
    ]
    alterations_by_subject = [find_alterations(subject.code.solution) for subject in subjects]
    jobs = [
        (subject, alteration)
        for subject, own_alterations in zip(subjects, alterations_by_subject, strict=True)
        for alteration in own_alterations
    ]
    tallies = []
    with closing(parallel.run_in_order(course, run_job, jobs, "Altérations")) as trials:
        for subject, own_alterations in zip(subjects, alterations_by_subject, strict=True):
            tallies.append(apply_marks_to_trials(subject, list(islice(trials, len(own_alterations)))))
            for text in exercise_report_lines(tallies[-1]):
                print(text, flush=True)
    print(summary_line(tallies))
    return 0 if all(exercise_tally.is_goal_reached for exercise_tally in tallies) else 1


def _has_code(exercise: Exercise) -> bool:
    return isinstance(exercise.grader, CodeGrader)


def load_subject(exercise: Exercise) -> MutationSubject:
    """Load an exercise with its marks. Raises CommandError without code, or where marks are unreadable."""
    code = exercise.grader
    if not isinstance(code, CodeGrader):
        raise CommandError(f"l’exercice « {exercise.id} » n’a pas de solution en Python à changer.")
    try:
        return MutationSubject(exercise, code, code.checks, exercise.policy, read_equivalents(code.folder))
    except MalformedExerciseError as error:
        raise CommandError(str(error)) from error


def run_job(grader: SandboxGrader, job: tuple[MutationSubject, Alteration]) -> MutantTrial:
    """Run one job in a worker process, which measures the solution once."""
    subject, alteration = job
    measured = _measure_or_explain(grader, subject)
    return (
        MutantTrial(alteration, MutantStatus.BROKEN, measured)
        if isinstance(measured, str)
        else try_alteration(grader, measured, alteration)
    )


@cache
def _measure_or_explain(grader: SandboxGrader, subject: MutationSubject) -> MutationSubject | str:
    """Return the subject with measured costs, or why they cannot be measured."""
    try:
        return with_measured_costs(grader, subject)
    except CommandError as reason:
        return str(reason)


def apply_marks_to_trials(subject: MutationSubject, trials: Sequence[MutantTrial]) -> MutantTally:
    """Sum up the results of an exercise's alterations, checked against its marks."""
    reasons = {trial.detail for trial in trials}
    if all(trial.fate is MutantStatus.BROKEN for trial in trials) and len(reasons) == 1:
        return MutantTally(subject.exercise.id, (), tuple(reasons))
    faults = [str(fault) for fault in find_stale_marks(subject.marks, [trial.alteration for trial in trials])]
    return MutantTally(subject.exercise.id, [_apply_marks(trial, subject.marks) for trial in trials], faults)


def _apply_marks(trial: MutantTrial, marks: Sequence[EquivalentMark]) -> MutantTrial:
    """Return the trial, adjusted where a mark concerns it."""
    if trial.fate is MutantStatus.BROKEN or not any(mark.matches(trial.alteration) for mark in marks):
        return trial
    return replace(
        trial, fate=MutantStatus.EQUIVALENT if trial.fate is MutantStatus.SURVIVED else MutantStatus.MISMARKED
    )


def with_measured_costs(grader: SandboxGrader, subject: MutationSubject) -> MutationSubject:
    """Return the subject with its checks ordered by their cost on the solution, and a time limit in proportion.

    Raises CommandError where the solution itself fails.
    """
    solution, costs = subject.code.solution, {}
    subject.find_catching_check(grader, solution, SEEDS[0])  # warms up what is slow the first time
    for check in subject.checks:
        started = time.monotonic()
        if replace(subject, checks=(check,)).find_catching_check(grader, solution, SEEDS[0]) is not None:
            raise CommandError(f"la solution elle-même échoue ({check.id}).")
        costs[check.id] = time.monotonic() - started
    time_limit = max(MIN_SECONDS, SLOWDOWN_LIMIT * sum(costs.values()))
    policy = replace(subject.policy, cpu_seconds=min(subject.policy.cpu_seconds, time_limit))
    return replace(subject, checks=tuple(sorted(subject.checks, key=lambda check: costs[check.id])), policy=policy)


def try_alteration(grader: SandboxGrader, subject: MutationSubject, alteration: Alteration) -> MutantTrial:
    """Try one alteration, regardless of marks."""
    started, fate, detail = time.monotonic(), MutantStatus.SURVIVED, ""
    try:
        for seed in SEEDS:
            failed = subject.find_catching_check(grader, alteration.altered, seed)
            if failed is not None:
                fate, detail = (MutantStatus.CAUGHT if seed == SEEDS[0] else MutantStatus.BY_CHANCE), failed
                break
    except Exception as error:
        fate, detail = MutantStatus.BROKEN, repr(error)
    return MutantTrial(alteration, fate, detail, time.monotonic() - started)


def exercise_report_lines(tally: MutantTally) -> Iterator[str]:
    """Yield one line for an exercise, then the diff of each notable alteration."""
    survived, equivalent = tally.trials_with(MutantStatus.SURVIVED), tally.trials_with(MutantStatus.EQUIVALENT)
    caught, of = tally.count_caught()
    seconds = sum(trial.seconds for trial in tally.trials)
    of_course = format_percent_rounded_down(*tally.count_caught(own=True))
    shares = f"{format_percent_rounded_down(caught, of)} ; du cours : {of_course}"
    yield (
        f"{'✓' if tally.is_goal_reached else '✗'} {tally.exercise:<24} altérations : {len(tally.trials)}, "
        f"tuées : {caught}, survivantes : {len(survived)}, équivalentes : {len(equivalent)} — "
        f"{shares} — {seconds:.0f} s"
    )
    for fault in tally.faults:
        yield f"  ✗ {fault}"
    for trial in tally.trials_with(
        MutantStatus.SURVIVED, MutantStatus.MISMARKED, MutantStatus.BROKEN, MutantStatus.BY_CHANCE
    ):
        alteration = trial.alteration
        where = f"ligne {alteration.line}" + (f", {alteration.function}" if alteration.function else "")
        detail = f" ({trial.detail})" if trial.detail else ""
        own = ", du cours" if alteration.is_course_mistake else ""
        yield f"  {where} — {alteration.operator}{own} : {trial.fate.value}{detail}"
        yield from (f"    {line}" for line in alteration.diff())


def format_percent_rounded_down(part: int, total: int) -> str:
    """« 97,5 % (39/40) »; rounded down, so that the goal never seems reached before it is."""
    tenths = part * 1000 // total if total else 1000
    return f"{format_number(tenths / 10)} % ({part}/{total})"


def summary_line(tallies: Sequence[MutantTally]) -> str:
    """Return the line for programs: totals of all exercises; `under` counts exercises below the goal."""
    caught, of = (sum(exercise_tally.count_caught()[k] for exercise_tally in tallies) for k in (0, 1))
    own, of_own = (sum(exercise_tally.count_caught(own=True)[k] for exercise_tally in tallies) for k in (0, 1))
    equivalent = sum(len(exercise_tally.trials_with(MutantStatus.EQUIVALENT)) for exercise_tally in tallies)
    under = sum(not exercise_tally.is_goal_reached for exercise_tally in tallies)
    return f"caught={caught}/{of} own={own}/{of_own} equivalent={equivalent} under={under}/{len(tallies)}"
