"""`balise check --mutants [EXERCISE…]`: do the checks of an exercise catch what is changed in its solution?

Each solution is altered at one place in every way that `graders.core.alterations` knows, and each altered program is
graded behind the walls, until a first check fails. What no check of no seed has failed has survived: its diff is told.
Those that are still right are marked by hand in the exercise's `equivalents.toml`; a mark of what is not there any
more, or of what a check fails, is a fault.
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
from graders.core.alterations.equivalents import EquivalentMark, read_equivalents, stale_marks
from graders.core.code.checks import Check
from graders.core.code.grading import CodeGrader
from graders.core.contract.malformed import MalformedExerciseError
from server.cli import CannotRun, parallel
from server.cli.report import number
from server.course import Course, Exercise
from server.grading.sandbox_grader import SandboxGrader
from server.sandbox import Policy

log = logging.getLogger(__name__)

#: The first seed, and those on which an altered program that passes is tried again: the same at each run.
SEEDS = (2026, 2027, 2028)
#: The shares that must be caught, of all alterations and of the course's own.
GOAL, GOAL_OF_OUR_OWN = 0.97, 1.0
#: An altered program that computes for so many times what the solution takes, and so many seconds at least, is stopped.
PATIENCE, LEAST_SECONDS = 10.0, 1.0
#: As often is a grading tried that fails for a reason of ours.
TRIES = 2


class Fate(Enum):
    """What became of an altered program."""

    CAUGHT = "tuée"
    BY_CHANCE = "tuée selon la graine"
    SURVIVED = "survit"
    EQUIVALENT = "équivalente"
    MISMARKED = "marquée équivalente, mais refusée"
    BROKEN = "correction échouée"


@dataclass(frozen=True)
class Trial:
    """An alteration, and what became of it; `said` is the check that caught it, or what went wrong with us."""

    alteration: Alteration
    fate: Fate
    said: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Tally:
    """What became of the alterations of one exercise; `faults` are those of its marks, or of its solution."""

    exercise: str
    trials: Sequence[Trial]
    faults: Sequence[str]

    def those(self, *fates: Fate, own: bool = False) -> list[Trial]:
        return [one for one in self.trials if one.fate in fates and (one.alteration.is_course_mistake or not own)]

    def caught(self, *, own: bool = False) -> tuple[int, int]:
        """How many were caught, of how many that are no equivalents."""
        caught = len(self.those(Fate.CAUGHT, Fate.BY_CHANCE, own=own))
        return caught, caught + len(self.those(Fate.SURVIVED, own=own))

    @property
    def well(self) -> bool:
        """Is the goal reached, and nothing wrong besides?"""
        reached = all(_share(*self.caught(own=own)) >= goal for own, goal in ((False, GOAL), (True, GOAL_OF_OUR_OWN)))
        return reached and not self.faults and not self.those(Fate.MISMARKED, Fate.BROKEN)


def _share(some: int, all_: int) -> float:
    return some / all_ if all_ else 1.0


@dataclass(frozen=True, eq=False)
class Subject:
    """An exercise whose solution is altered: its checks, the cheapest first, under a policy that is cut short."""

    exercise: Exercise
    code: CodeGrader
    checks: tuple[Check, ...]
    policy: Policy
    marks: Sequence[EquivalentMark]

    def first_failed(self, grader: SandboxGrader, source: str, seed: int) -> str | None:
        """The check that catches a program. What is raised, twice in a row, is our own failure."""
        for _ in range(TRIES - 1):
            try:
                return self._first_failed(grader, source, seed)
            except Exception:
                log.exception("an altered %s could not be graded with seed %d", self.exercise.id, seed)
        return self._first_failed(grader, source, seed)

    def _first_failed(self, grader: SandboxGrader, source: str, seed: int) -> str | None:
        programs = grader.programs(self.exercise.id, self.policy)
        return self.code.first_failed(source.encode(), programs, seed=seed, checks=self.checks)


def run(course: Course, asked: Sequence[Exercise]) -> int:
    """Tries and tells; 1 under the goal, or where a mark is wrong. Where none is asked for, all exercises of code.

    Raises CannotRun for one that was asked for and has no code, and for marks that cannot be read.
    """
    subjects = [subject_of(exercise) for exercise in asked or course.exercises.values() if asked or _coded(exercise)]
    found = [find_alterations(subject.code.solution) for subject in subjects]
    jobs = [(subject, alteration) for subject, its in zip(subjects, found, strict=True) for alteration in its]
    tallies = []
    with closing(parallel.in_order(course, work, jobs, "Altérations")) as trials:
        for subject, its in zip(subjects, found, strict=True):
            tallies.append(tally(subject, list(islice(trials, len(its)))))
            for text in told(tallies[-1]):
                print(text, flush=True)
    print(summary(tallies))
    return 0 if all(one.well for one in tallies) else 1


def _coded(exercise: Exercise) -> bool:
    return isinstance(exercise.grader, CodeGrader)


def subject_of(exercise: Exercise) -> Subject:
    """The exercise with its marks. Raises CannotRun where there is no code, or marks that cannot be read."""
    code = exercise.grader
    if not isinstance(code, CodeGrader):
        raise CannotRun(f"l’exercice « {exercise.id} » n’a pas de solution en Python à changer.")
    try:
        return Subject(exercise, code, code.checks, exercise.policy, read_equivalents(code.folder))
    except MalformedExerciseError as error:
        raise CannotRun(str(error)) from error


def work(grader: SandboxGrader, job: tuple[Subject, Alteration]) -> Trial:
    """One job, in a process of its own: the solution is measured once in each."""
    subject, alteration = job
    ready = _ready(grader, subject)
    return Trial(alteration, Fate.BROKEN, ready) if isinstance(ready, str) else tried(grader, ready, alteration)


@cache
def _ready(grader: SandboxGrader, subject: Subject) -> Subject | str:
    """The subject as it is measured, or why it cannot be."""
    try:
        return measured(grader, subject)
    except CannotRun as reason:
        return str(reason)


def tally(subject: Subject, trials: Sequence[Trial]) -> Tally:
    """What became of the alterations of an exercise, held against its marks."""
    reasons = {trial.said for trial in trials}
    if all(trial.fate is Fate.BROKEN for trial in trials) and len(reasons) == 1:
        return Tally(subject.exercise.id, (), tuple(reasons))
    faults = [str(fault) for fault in stale_marks(subject.marks, [trial.alteration for trial in trials])]
    return Tally(subject.exercise.id, [_held(trial, subject.marks) for trial in trials], faults)


def _held(trial: Trial, marks: Sequence[EquivalentMark]) -> Trial:
    """The same trial where no mark speaks of it."""
    if trial.fate is Fate.BROKEN or not any(mark.matches(trial.alteration) for mark in marks):
        return trial
    return replace(trial, fate=Fate.EQUIVALENT if trial.fate is Fate.SURVIVED else Fate.MISMARKED)


def measured(grader: SandboxGrader, subject: Subject) -> Subject:
    """The same, with its checks in the order of what they cost the solution, and time in proportion to it.

    Raises CannotRun where the solution itself fails: nothing can be said of its alterations.
    """
    solution, costs = subject.code.solution, {}
    subject.first_failed(grader, solution, SEEDS[0])  # what is slow the first time is
    for check in subject.checks:
        begun = time.monotonic()
        if replace(subject, checks=(check,)).first_failed(grader, solution, SEEDS[0]) is not None:
            raise CannotRun(f"la solution elle-même échoue ({check.id}).")
        costs[check.id] = time.monotonic() - begun
    patience = max(LEAST_SECONDS, PATIENCE * sum(costs.values()))
    policy = replace(subject.policy, cpu_seconds=min(subject.policy.cpu_seconds, patience))
    return replace(subject, checks=tuple(sorted(subject.checks, key=lambda check: costs[check.id])), policy=policy)


def tried(grader: SandboxGrader, subject: Subject, alteration: Alteration) -> Trial:
    """What becomes of one alteration, marks left aside."""
    begun, fate, said = time.monotonic(), Fate.SURVIVED, ""
    try:
        for seed in SEEDS:
            failed = subject.first_failed(grader, alteration.altered, seed)
            if failed is not None:
                fate, said = (Fate.CAUGHT if seed == SEEDS[0] else Fate.BY_CHANCE), failed
                break
    except Exception as error:
        fate, said = Fate.BROKEN, repr(error)
    return Trial(alteration, fate, said, time.monotonic() - begun)


def told(tally: Tally) -> Iterator[str]:
    """One line for an exercise, then the diff of each alteration of which something is to be said."""
    survived, equivalent = tally.those(Fate.SURVIVED), tally.those(Fate.EQUIVALENT)
    caught, of = tally.caught()
    seconds = sum(trial.seconds for trial in tally.trials)
    shares = f"{percent(caught, of)} ; du cours : {percent(*tally.caught(own=True))}"
    yield (
        f"{'✓' if tally.well else '✗'} {tally.exercise:<24} altérations : {len(tally.trials)}, tuées : {caught}, "
        f"survivantes : {len(survived)}, équivalentes : {len(equivalent)} — {shares} — {seconds:.0f} s"
    )
    for fault in tally.faults:
        yield f"  ✗ {fault}"
    for trial in tally.those(Fate.SURVIVED, Fate.MISMARKED, Fate.BROKEN, Fate.BY_CHANCE):
        alteration = trial.alteration
        where = f"ligne {alteration.line}" + (f", {alteration.function}" if alteration.function else "")
        said = f" ({trial.said})" if trial.said else ""
        own = ", du cours" if alteration.is_course_mistake else ""
        yield f"  {where} — {alteration.operator}{own} : {trial.fate.value}{said}"
        yield from (f"    {line}" for line in alteration.diff())


def percent(some: int, all_: int) -> str:
    """« 97,5 % (39/40) »; rounded down, so that the goal is not said to be reached before it is."""
    tenths = some * 1000 // all_ if all_ else 1000
    return f"{number(tenths / 10)} % ({some}/{all_})"


def summary(tallies: Sequence[Tally]) -> str:
    """The line that programs read: of all exercises together, but for `under`, the exercises under the goal."""
    caught, of = (sum(one.caught()[k] for one in tallies) for k in (0, 1))
    own, of_own = (sum(one.caught(own=True)[k] for one in tallies) for k in (0, 1))
    equivalent = sum(len(one.those(Fate.EQUIVALENT)) for one in tallies)
    under = sum(not one.well for one in tallies)
    return f"caught={caught}/{of} own={own}/{of_own} equivalent={equivalent} under={under}/{len(tallies)}"
