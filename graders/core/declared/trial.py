"""The trial of a declared exercise, for its author: does the solution answer, are its mistakes refused and named?

The solution is also changed in one place at a time: each change must be refused. One that is not, though some input
shows it, survives, and that input is proposed as a case. Everything of the author's runs behind the walls.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from graders.core.alterations.alterations import Alteration, sample_alterations
from graders.core.compare.python_values import Raised, python_text
from graders.core.contract.kits import SCENARIOS
from graders.core.contract.program import KitSettings, Programs, StudentFault
from graders.core.contract.values import Value
from graders.core.contract.verdict import MAX_POINTS
from graders.core.declared.declaration import Declaration, DeclaredCheck, read_declaration
from graders.core.declared.grading import DeclaredGrader, Fingerprint, SolutionFault
from graders.core.declared.judging import Case, expected_is_given, is_answered, judge, observed
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.playing import Played, Player
from graders.core.declared.scenarios import PROGRAM, Scenario
from graders.core.declared.variations import vary_cases

#: Changes of a solution that are tried; the share of them that may survive; seeds of the solution before publication.
MAX_CHANGES, MAX_ALIVE, SEEDS = 48, 0.03, 20
TRIAL_SEED = 1
#: Seconds after which a trial ends, and says that it did not try everything.
TRIAL_SECONDS = 40.0
MAX_MESSAGE = 400
#: A changed solution that takes so many times as long as the solution loops: in seconds, from least to most.
BRIEF_FACTOR, MIN_BRIEF_SECONDS, MAX_BRIEF_SECONDS = 10.0, 0.1, 1.0
#: Inputs near the examples that are played together: one of them may never end.
SCENARIOS_AT_ONCE = 8


@dataclass(frozen=True)
class TriedCase:
    """A written case: what the solution answers, as Python writes it, or why it does not; whether that is expected."""

    check: int
    case: int
    given: str
    agrees: bool
    fault: str = ""


@dataclass(frozen=True)
class TriedMistake:
    """A known mistake: whether it is refused and named, and which mistake is named in its stead."""

    id: str
    refused: bool
    named: bool
    instead: str = ""


@dataclass(frozen=True)
class TriedChange:
    """A change of the solution: the lines before and after, the changed program, and how a case refuses it.

    `case` is an input that shows it though no case does; `unseen` says that none was found.
    """

    line: int
    before: str
    after: str
    program: str
    refusal: str = ""
    check: int = 0
    case: str = ""
    unseen: bool = False

    @property
    def survives(self) -> bool:
        return not self.refusal and not self.unseen


@dataclass(frozen=True)
class TrialReport:
    """A trial. `problem` is what keeps the declaration from being read, at `place`."""

    place: str = ""
    problem: str = ""
    cases: tuple[TriedCase, ...] = ()
    solution: str = ""
    starter: str = ""
    mistakes: tuple[TriedMistake, ...] = ()
    changes: tuple[TriedChange, ...] = ()
    seeds: int = 0
    is_whole: bool = True

    @property
    def survivors(self) -> tuple[TriedChange, ...]:
        return tuple(change for change in self.changes if change.survives)

    def to_data(self) -> dict[str, Any]:
        return asdict(self)

    @classmethod
    def from_data(cls, data: Mapping[str, Any]) -> TrialReport:
        """Return the report that `to_data` gave."""
        lists = {
            "cases": tuple(TriedCase(**each) for each in data["cases"]),
            "mistakes": tuple(TriedMistake(**each) for each in data["mistakes"]),
            "changes": tuple(TriedChange(**each) for each in data["changes"]),
        }
        return cls(**{**data, **lists})


class ExerciseTrial:
    """Tries one declaration. `start` gives a starter of programs, a new one for each program.

    `start_briefly` does so for programs that may loop, of which many are tried: each has so many seconds.
    """

    def __init__(
        self,
        exercise: str,
        start: Callable[[], Programs],
        start_briefly: Callable[[float], Programs],
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._exercise, self._start, self._start_briefly, self._clock = exercise, start, start_briefly, clock
        self._brief_seconds = MAX_BRIEF_SECONDS

    def run(self, data: Mapping[str, Any], starter: str, *, seeds: int = 0, with_changes: bool = True) -> TrialReport:
        """Return the report; the solution is graded on so many `seeds`, and changed where `with_changes`."""
        until = self._clock() + TRIAL_SECONDS
        try:
            declaration = read_declaration(data)
        except MalformedDeclaration as error:
            fault = self._load_fault(str(data.get("solution", "")), data.get("fonctions"))
            return TrialReport(solution=fault) if fault else TrialReport(error.place, error.message)
        grader = DeclaredGrader(self._exercise, declaration)
        cases, fault = self._try_cases(grader)
        if fault or not all(case.agrees for case in cases):
            return TrialReport(cases=cases, solution=fault)
        starter_fault = "" if self._points(grader, starter) < MAX_POINTS else "Le départ a déjà tous les points."
        graded = 0
        for seed in range(seeds):
            fault = self._grade_solution(grader, seed)
            if fault or self._clock() > until:
                return TrialReport(cases=cases, solution=fault, starter=starter_fault, seeds=graded, is_whole=not fault)
            graded += 1
        mistakes = tuple(self._try_mistakes(grader))
        changes = tuple(self._try_changes(grader, until)) if with_changes else ()
        return TrialReport(
            cases=cases, starter=starter_fault, mistakes=mistakes, changes=changes, seeds=graded,
            is_whole=self._clock() <= until,
        )  # fmt: skip

    def _load_fault(self, solution: str, functions: object) -> str:
        """Return why a solution does not load; empty where it does."""
        whole: dict[str, Value] = {"whole_program": PROGRAM} if functions == [PROGRAM] else {}
        try:
            self._start().open(solution.encode(), KitSettings(SCENARIOS, {"seed": 0, "functions": (), **whole})).close()
        except StudentFault as fault:
            return _message(fault)
        return ""

    def fingerprints(self, declaration: Declaration) -> dict[str, Fingerprint]:
        """Return what each known mistake answers to the probes."""
        grader = DeclaredGrader(self._exercise, declaration)
        return {each.id: grader.fingerprint(each.program.encode(), self._start()) for each in declaration.mistakes}

    def answers(self, data: Mapping[str, Any]) -> list[list[str]] | None:
        """Return what the solution gives in each written case, by check; None where it fails in one."""
        declaration = read_declaration(data)
        cases, fault = self._try_cases(DeclaredGrader(self._exercise, declaration))
        if fault or any(case.fault for case in cases):
            return None
        return [[case.given for case in cases if case.check == at] for at in range(len(declaration.checks))]

    def draws_are_answered(self, data: Mapping[str, Any]) -> bool:
        """Whether the solution gives a value, and no exception, to the inputs that a declaration draws."""
        try:
            grader = DeclaredGrader(self._exercise, read_declaration(data))
        except MalformedDeclaration:
            return False
        cases = [case for check in grader.declaration.checks for case in grader.cases(check, TRIAL_SEED)]
        drawn = [case.scenario for case in cases if case.drawn is not None]
        return all(played.fault is None and played.raised is None for played in self._play(grader, drawn))

    def _play(self, grader: DeclaredGrader, scenarios: Sequence[Scenario], *, briefly: bool = False) -> list[Played]:
        """Return what the solution does; `briefly`, few scenarios at a time, as some may never end."""
        player = self._player(grader, grader.solution, briefly=briefly)
        size = SCENARIOS_AT_ONCE if briefly else max(1, len(scenarios))
        try:
            parts = (scenarios[start : start + size] for start in range(0, len(scenarios), size))
            return [played for part in parts for played in player.play(part)]
        finally:
            player.close()

    def _player(self, grader: DeclaredGrader, source: str, *, briefly: bool = False) -> Player:
        programs = self._start_briefly(self._brief_seconds) if briefly else self._start()
        return Player(programs, source.encode(), grader.kit(TRIAL_SEED))

    def _try_cases(self, grader: DeclaredGrader) -> tuple[tuple[TriedCase, ...], str]:
        """Return what the solution does in the written cases, and why it does not load."""
        checks = grader.declaration.checks
        written = [(at, number, case) for at, check in enumerate(checks) for number, case in enumerate(check.cases)]
        player = self._player(grader, grader.solution)
        try:
            played = player.start([case for _, _, case in written]) if written else []
        except StudentFault as fault:
            return (), _message(fault)
        finally:
            player.close()
        pairs = zip(written, played, strict=True)
        return tuple(_tried_case(checks[at], at, number, case, got) for (at, number, case), got in pairs), ""

    def _points(self, grader: DeclaredGrader, source: str) -> float:
        return grader.grade(source.encode(), self._start(), seed=TRIAL_SEED, version="").verdict.points

    def _grade_solution(self, grader: DeclaredGrader, seed: int) -> str:
        """Return why the solution does not get all points on a seed; empty where it does."""
        try:
            verdict = grader.grade(grader.solution.encode(), self._start(), seed=seed, version="").verdict
        except SolutionFault as fault:
            return str(fault)[:MAX_MESSAGE]
        failed = next((check for check in verdict.checks if not check.passed), None)
        return "" if failed is None else f"Votre solution n’a pas tous les points : {failed.message}"[:MAX_MESSAGE]

    def _try_mistakes(self, grader: DeclaredGrader) -> Iterator[TriedMistake]:
        for mistake in grader.declaration.mistakes:
            try:
                verdict = grader.grade(mistake.program.encode(), self._start(), seed=TRIAL_SEED, version="").verdict
            except SolutionFault:
                yield TriedMistake(mistake.id, refused=False, named=False)
                continue
            named = verdict.diagnosis.id if verdict.diagnosis else ""
            refused = verdict.points < MAX_POINTS
            yield TriedMistake(mistake.id, refused, named == mistake.id, "" if named == mistake.id else named)

    def _try_changes(self, grader: DeclaredGrader, until: float) -> Iterator[TriedChange]:
        """Yield the changes of the solution that were tried in time."""
        checks = grader.declaration.checks
        cases = [(at, case) for at, check in enumerate(checks) for case in grader.cases(check, TRIAL_SEED)]
        started = self._clock()
        right = self._play(grader, [case.scenario for _, case in cases])
        patience = BRIEF_FACTOR * (self._clock() - started)
        self._brief_seconds = min(MAX_BRIEF_SECONDS, max(MIN_BRIEF_SECONDS, patience))
        nearby = [(at, scenario) for at, check in enumerate(checks) for scenario in vary_cases(check)]
        answered = zip(nearby, self._play(grader, [scenario for _, scenario in nearby], briefly=True), strict=True)
        near = [(at, Case(scenario), got) for (at, scenario), got in answered if got.fault is None and not got.raised]
        known = [(at, case, got) for (at, case), got in zip(cases, right, strict=True) if is_answered(got)]
        for alteration in sample_alterations(grader.solution, MAX_CHANGES):
            if self._clock() > until:
                return
            yield self._try_change(grader, alteration, known, near)

    def _try_change(
        self,
        grader: DeclaredGrader,
        alteration: Alteration,
        known: Sequence[tuple[int, Case, Played]],
        near: Sequence[tuple[int, Case, Played]],
    ) -> TriedChange:
        change = TriedChange(
            alteration.line, "\n".join(alteration.removed), "\n".join(alteration.added), alteration.altered
        )
        checks = grader.declaration.checks
        player = self._player(grader, alteration.altered, briefly=True)
        try:
            for is_known, trios in ((True, known), (False, near)):
                played = player.play([case.scenario for _, case, _ in trios])
                judged = (
                    (at, judge(checks[at], case, right, got))
                    for (at, case, right), got in zip(trios, played, strict=True)
                )
                at, failure = next(((at, found) for at, found in judged if found is not None), (0, None))
                if failure is None:
                    continue
                if not is_known:
                    return TriedChange(
                        **{**asdict(change), "case": failure.case.scenario.exact_text() or "", "check": at}
                    )
                words = grader.describe_failure(checks[at], failure).result.message
                return TriedChange(**{**asdict(change), "refusal": words[:MAX_MESSAGE], "check": at})
        finally:
            player.close()
        return TriedChange(**{**asdict(change), "unseen": True})


def _tried_case(check: DeclaredCheck, at: int, number: int, case: Scenario, got: Played) -> TriedCase:
    if not is_answered(got):
        return TriedCase(at, number, "", agrees=False, fault=_message(got.fault) if got.fault else "")
    given: Value = observed(check, got, len(case.statements) - 1)
    as_expected = not case.expected or expected_is_given(check, case.expected[0], got, len(case.statements) - 1)
    text = str(given) if isinstance(given, Raised) else python_text(given, None)
    return TriedCase(at, number, text[:MAX_MESSAGE], agrees=as_expected)


def _message(fault: StudentFault) -> str:
    return fault.message.partition("\n")[0][:MAX_MESSAGE]
