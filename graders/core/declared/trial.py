"""The trial of a declared exercise, for its author: does the solution answer, are its mistakes refused and named?

The solution is also changed in one place at a time: each change must be refused. One that is not, though some input
shows it, survives, and that input is proposed as a case. Everything of the author's runs behind the walls.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import closing
from dataclasses import replace
from typing import Any, Protocol

from graders.core.alterations.alterations import Alteration, sample_alterations
from graders.core.contract.kits import SCENARIOS
from graders.core.contract.program import KitSettings, Programs, StudentFault
from graders.core.contract.values import Value
from graders.core.contract.verdict import MAX_POINTS
from graders.core.declared.body_changes import change_bodies
from graders.core.declared.call_changes import change_calls
from graders.core.declared.declaration import Declaration, DeclaredCheck, read_declaration
from graders.core.declared.grading import DeclaredGrader, Fingerprint, SolutionFault
from graders.core.declared.judging import gives_expected_value, is_answered, judge, observed_value
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.playing import PlayedScenario, Player
from graders.core.declared.probe_answers import behaviour_digest, probe_answer
from graders.core.declared.references import make_reference
from graders.core.declared.scenarios import PROGRAM, Scenario
from graders.core.declared.trial_report import TrialReport, TriedCase, TriedChange, TriedMistake
from graders.core.declared.tried_inputs import (
    MAX_MESSAGE,
    TRIAL_SEED,
    ProposedCase,
    TriedInputs,
    answer_text,
    fails_within_limits,
    given_value_text,
    split_into_chunks,
)

#: Changes of a solution that are tried; the share of them that may survive; seeds of the solution before publication.
MAX_CHANGES, MAX_ALIVE, SEEDS = 48, 0.03, 20
#: Seconds of the processor after which a trial ends, and says that it did not try everything; seconds in all.
TRIAL_SECONDS, MAX_TRIAL_SECONDS = 40.0, 120.0
#: A changed solution that takes so many times as long as the solution loops: in seconds of the processor.
BRIEF_FACTOR, MIN_BRIEF_SECONDS, MAX_BRIEF_SECONDS = 10.0, 0.1, 1.0


class MeasuredPrograms(Programs, Protocol):
    """Programs of one file whose processor time is known."""

    @property
    def cpu_seconds(self) -> float:
        """The processor time of the programs that were started, which are closed."""
        ...


class ExerciseTrial:
    """Tries one declaration. `start` gives a starter of programs, a new one for each program.

    `start_briefly` does so for programs that may loop, of which many are tried: each has so many seconds of the
    processor.
    """

    def __init__(
        self,
        exercise: str,
        start: Callable[[], MeasuredPrograms],
        start_briefly: Callable[[float], MeasuredPrograms],
        *,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._exercise, self._make, self._make_briefly, self._clock = exercise, start, start_briefly, clock
        self._brief_seconds = MAX_BRIEF_SECONDS
        self._began, self._started = clock(), list[MeasuredPrograms]()

    def run(self, data: Mapping[str, Any], starter: str, *, seeds: int = 0, with_changes: bool = True) -> TrialReport:
        """Return the report; the solution is graded on so many `seeds`, and changed where `with_changes`."""
        self._began, self._started = self._clock(), []
        try:
            declaration = read_declaration(data)
        except MalformedDeclaration as error:
            fault = self._find_load_fault(str(data.get("solution", "")), data.get("fonctions"))
            return TrialReport(solution=fault) if fault else TrialReport(error.place, error.message)
        grader = DeclaredGrader(self._exercise, declaration)
        cases, fault = self._try_cases(grader)
        if fault or not all(case.agrees for case in cases):
            return TrialReport(cases=cases, solution=fault)
        starter_fault = "" if self._grade_points(grader, starter) < MAX_POINTS else "Le départ a déjà tous les points."
        graded = 0
        for seed in range(seeds):
            fault = self._grade_solution(grader, seed)
            if fault or self._is_time_over():
                return self._complete_report(
                    TrialReport(cases=cases, solution=fault, starter=starter_fault, seeds=graded)
                )
            graded += 1
        inputs = TriedInputs(grader, self._play_solution_at_length, self._play_solution_briefly)
        mistakes = tuple(self._try_mistakes(grader, inputs))
        changes = tuple(self._try_changes(grader, inputs)) if with_changes else ()
        report = TrialReport(
            cases=cases,
            starter=starter_fault,
            mistakes=mistakes,
            changes=changes,
            seeds=graded,
            raising=inputs.first_raising_input,
        )
        return self._complete_report(report)

    def _start_programs(self) -> Programs:
        self._started.append(self._make())
        return self._started[-1]

    def _elapsed_seconds(self) -> float:
        """Return the time since the trial began, in seconds."""
        return self._clock() - self._began

    def _used_cpu_seconds(self) -> float:
        """Return the processor time of the programs, all closed, in seconds."""
        return sum(programs.cpu_seconds for programs in self._started)

    def _is_time_over(self) -> bool:
        seconds = self._elapsed_seconds()
        return seconds > TRIAL_SECONDS and (seconds > MAX_TRIAL_SECONDS or self._used_cpu_seconds() > TRIAL_SECONDS)

    def _complete_report(self, report: TrialReport) -> TrialReport:
        """Return the report, with whether everything was tried in time, and whether others had the processor."""
        is_over = self._is_time_over()
        return replace(report, is_whole=not is_over, is_busy=is_over and self._used_cpu_seconds() <= TRIAL_SECONDS)

    def _find_load_fault(self, solution: str, functions: object) -> str:
        """Return why a solution does not load; empty where it does."""
        whole: dict[str, Value] = {"whole_program": PROGRAM} if functions == [PROGRAM] else {}
        try:
            self._start_programs().open(
                solution.encode(), KitSettings(SCENARIOS, {"seed": 0, "functions": (), **whole})
            ).close()
        except StudentFault as fault:
            return _fault_text(fault)
        return ""

    def fingerprints(self, declaration: Declaration) -> dict[str, Fingerprint]:
        """Return what each known mistake answers to the probes."""
        grader = DeclaredGrader(self._exercise, declaration)
        return {
            each.id: grader.fingerprint(each.program.encode(), self._start_programs()) for each in declaration.mistakes
        }

    def answer_written_cases(self, data: Mapping[str, Any]) -> list[list[str]] | None:
        """Return what must be given in each written case, by check; None where the solution fails in one."""
        declaration = read_declaration(data)
        cases, fault = self._try_cases(DeclaredGrader(self._exercise, declaration))
        if fault or any(case.fault for case in cases):
            return None
        checks = range(len(declaration.checks))
        return [[case.typed or case.given for case in cases if case.check == at] for at in checks]

    def answer_draws(self, data: Mapping[str, Any]) -> list[tuple[str, str]]:
        """Return the inputs that a declaration draws, with what the solution gives; none where it fails in one."""
        try:
            grader = DeclaredGrader(self._exercise, read_declaration(data))
        except MalformedDeclaration:
            return []
        checks = grader.declaration.checks
        drawn = [
            (check, case) for check in checks for case in grader.cases(check, TRIAL_SEED) if case.drawn is not None
        ]
        played = self._play_solution(grader, [case.scenario for _, case in drawn])
        if any(each.fault is not None or each.raised is not None for each in played):
            return []
        return [
            (case.scenario.text(), answer_text(check, case.scenario, got))
            for (check, case), got in zip(drawn, played, strict=True)
        ]

    def _play_solution(self, grader: DeclaredGrader, scenarios: Sequence[Scenario]) -> list[PlayedScenario]:
        """Return what the solution does."""
        with closing(self._make_player(grader, grader.solution)) as player:
            return player.play(scenarios)

    def _play_solution_at_length(self, grader: DeclaredGrader, scenarios: Sequence[Scenario]) -> list[PlayedScenario]:
        """Return what the solution does, and allow programs that may loop so many times as long."""
        played = self._play_solution(grader, scenarios)
        patience = BRIEF_FACTOR * self._started[-1].cpu_seconds  # a busy machine makes no program slower by it
        self._brief_seconds = min(MAX_BRIEF_SECONDS, max(MIN_BRIEF_SECONDS, patience))
        return played

    def _play_solution_briefly(self, grader: DeclaredGrader, scenarios: Sequence[Scenario]) -> list[PlayedScenario]:
        return self.play_briefly(grader, grader.solution, scenarios)

    def play_briefly(self, grader: DeclaredGrader, source: str, scenarios: Sequence[Scenario]) -> list[PlayedScenario]:
        """Return what a program does, a few scenarios at a time, as some may never end."""
        with closing(self._make_player(grader, source, briefly=True)) as player:
            return [played for part in split_into_chunks(scenarios) for played in player.play(part)]

    def _make_player(self, grader: DeclaredGrader, source: str, *, briefly: bool = False) -> Player:
        self._started.append(self._make_briefly(self._brief_seconds) if briefly else self._make())
        return Player(self._started[-1], source.encode(), grader.kit(TRIAL_SEED))

    def _try_cases(self, grader: DeclaredGrader) -> tuple[tuple[TriedCase, ...], str]:
        """Return what the solution does in the written cases, and why it does not load."""
        checks = grader.declaration.checks
        written = [(at, number, case) for at, check in enumerate(checks) for number, case in enumerate(check.cases)]
        player = self._make_player(grader, grader.solution)
        try:
            played = player.start([case for _, _, case in written]) if written else []
        except StudentFault as fault:
            return (), _fault_text(fault)
        finally:
            player.close()
        pairs = zip(written, played, strict=True)
        return tuple(_describe_tried_case(checks[at], at, number, case, got) for (at, number, case), got in pairs), ""

    def _grade_points(self, grader: DeclaredGrader, source: str) -> float:
        return grader.grade(source.encode(), self._start_programs(), seed=TRIAL_SEED, version="").verdict.points

    def _grade_solution(self, grader: DeclaredGrader, seed: int) -> str:
        """Return why the solution does not get all points on a seed; empty where it does."""
        try:
            verdict = grader.grade(grader.solution.encode(), self._start_programs(), seed=seed, version="").verdict
        except SolutionFault as fault:
            return str(fault)[:MAX_MESSAGE]
        failed = next((check for check in verdict.checks if not check.passed), None)
        return "" if failed is None else f"Votre solution n’a pas tous les points : {failed.message}"[:MAX_MESSAGE]

    def _try_mistakes(self, grader: DeclaredGrader, inputs: TriedInputs) -> Iterator[TriedMistake]:
        programs = {mistake.id: mistake.program for mistake in grader.declaration.mistakes}
        for name, program in programs.items():
            try:
                verdict = grader.grade(program.encode(), self._start_programs(), seed=TRIAL_SEED, version="").verdict
            except SolutionFault:
                yield TriedMistake(name, refused=False, named=False)
                continue
            named = verdict.diagnosis.id if verdict.diagnosis else ""
            if verdict.points == MAX_POINTS:
                found = self._find_case(grader, program, inputs)
                yield TriedMistake(name, False, False, **found._asdict())
            elif named != name and named in programs:
                found = self._find_case(grader, program, inputs, unlike=programs[named])
                yield TriedMistake(name, True, False, named, **found._asdict())
            else:
                yield TriedMistake(name, True, named == name, "" if named == name else named)

    def _find_case(
        self, grader: DeclaredGrader, program: str, inputs: TriedInputs, *, unlike: str = ""
    ) -> ProposedCase:
        """Return an input to which a program answers otherwise than the solution, or than another program; an empty
        one where none was found."""
        scenarios = [case.scenario for _, case, _ in inputs.near_cases]
        played = self.play_briefly(grader, program, scenarios)
        others = self.play_briefly(grader, unlike, scenarios) if unlike else played
        for (at, case, right), got, other in zip(inputs.near_cases, played, others, strict=True):
            wrong = fails_within_limits(judge(grader.declaration.checks[at], case, right, got))
            if wrong and (not unlike or probe_answer(got) != probe_answer(other)):
                return inputs.describe_case(at, case, right)
        return ProposedCase()

    def _try_changes(self, grader: DeclaredGrader, inputs: TriedInputs) -> Iterator[TriedChange]:
        """Yield the changes of the solution that were tried in time: those of whole functions first.

        Of one function, those that survive for want of different cases are one.
        """
        proposed = set[tuple[str, str]]()
        for body in change_bodies(grader.solution, grader.functions, inputs.seen_calls, inputs.printed_texts):
            if self._is_time_over():
                return
            tried = replace(self._try_change(grader, body.alteration, inputs), words=body.words)
            tried = replace(tried, unseen=tried.unseen and not body.is_asked)
            place = (f"{body.alteration.function} {tried.operator}", tried.case)
            if not tried.survives or place not in proposed:
                yield tried
            proposed |= {place} if tried.survives else set()
        for alteration in _list_alterations(grader.solution):
            if self._is_time_over():
                return
            yield self._try_change(grader, alteration, inputs)

    def _try_change(self, grader: DeclaredGrader, alteration: Alteration, inputs: TriedInputs) -> TriedChange:
        removed, added = "\n".join(alteration.removed_lines), "\n".join(alteration.added_lines)
        change = TriedChange(alteration.line, removed, added, alteration.altered, operator=alteration.operator)
        checks = grader.declaration.checks
        player = self._make_player(grader, alteration.altered, briefly=True)
        try:
            for is_known, trios in (
                (True, inputs.known_cases),
                *((False, part) for part in inputs.iter_near_case_chunks),
            ):
                played = player.play([case.scenario for _, case, _ in trios])
                judged = (
                    (at, right, judge(checks[at], case, right, got))
                    for (at, case, right), got in zip(trios, played, strict=True)
                )
                failures = ((at, right, failure) for at, right, failure in judged if failure is not None)
                found = next((each for each in failures if is_known or fails_within_limits(each[2])), None)
                if found is None:
                    continue
                at, right, failure = found
                if not is_known:
                    return replace(change, **inputs.describe_case(at, failure.case, right)._asdict())
                words = grader.describe_failure(checks[at], failure).result.message
                return replace(change, refusal=words[:MAX_MESSAGE], check=at, behaviour=behaviour_digest(played))
        finally:
            player.close()
        return replace(change, unseen=True)


def _list_alterations(solution: str) -> list[Alteration]:
    """Return the changes of a solution that are tried, each program once."""
    calls = change_calls(solution)[: MAX_CHANGES // 4]
    changes = [*sample_alterations(solution, MAX_CHANGES - len(calls)), *calls]
    return sorted({change.altered: change for change in changes}.values(), key=lambda change: change.line)


def _describe_tried_case(check: DeclaredCheck, at: int, number: int, case: Scenario, got: PlayedScenario) -> TriedCase:
    if not is_answered(got):
        return TriedCase(at, number, "", agrees=False, fault=_fault_text(got.fault) if got.fault else "")
    if got.fault is not None and not case.expected:
        return TriedCase(at, number, "", agrees=False, fault=_fault_text(got.fault), raised=got.fault.exception or "")
    check, last = check.with_tolerance_of_case(case), len(case.statements) - 1
    given: Value = observed_value(check, got, last)
    if case.expected and not gives_expected_value(check, case.expected[0], got, last):
        return TriedCase(at, number, given_value_text(given), agrees=False)
    typed = given_value_text(observed_value(check, make_reference(check, case, got), last))
    return TriedCase(
        at, number, given_value_text(given), agrees=True, typed=typed if typed != given_value_text(given) else ""
    )


def _fault_text(fault: StudentFault) -> str:
    return fault.message.partition("\n")[0][:MAX_MESSAGE]
