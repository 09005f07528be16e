"""Grading of declared exercises: the solution and the student's file play the same scenarios, in separate processes.

The trusted side draws the scenarios, compares what both did, simplifies a counterexample, and words the verdict. No
code of the author runs in this process.
"""

from __future__ import annotations

import ast
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path

from graders.core.code.finding_messages import shorten_repeated_reasons
from graders.core.code.folder import Specimen, read_specimens
from graders.core.compare.python_values import python_text_pair
from graders.core.contract.findings import Finding, Judgement, make_verdict
from graders.core.contract.kits import SCENARIOS
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, PreparablePrograms, Programs, StudentFault, clock_of_programs
from graders.core.contract.protocol import KnownSubmission, WhileNaming, no_early_verdict
from graders.core.contract.streams import stream
from graders.core.contract.values import Value
from graders.core.contract.verdict import CheckResult, Diagnosis
from graders.core.declared.case_reading import parse_scenario
from graders.core.declared.declaration import Declaration, DeclaredCheck
from graders.core.declared.figure_data import describe_figure
from graders.core.declared.judging import (
    Case,
    FailedCase,
    fails_alike,
    gives_expected_value,
    is_answered,
    judge,
    observed_value,
)
from graders.core.declared.malformed import MalformedDeclaration
from graders.core.declared.playing import PlayedScenario, Player
from graders.core.declared.probe_answers import find_mistake, probe_answer
from graders.core.declared.scenario_values import Reference
from graders.core.declared.scenarios import Scenario
from graders.core.declared.shared_state import replay_failure_alone
from graders.core.declared.wording import failed_finding, failure_message, fault_finding, slip_diagnosis
from graders.core.syntax_trees import parse_source

#: Bounds of the search for a simpler counterexample: scenarios in one exchange, in all, and seconds.
SIMPLER_AT_ONCE, MAX_SIMPLER, SIMPLER_SECONDS = 12, 72, 0.25
#: Drawn cases of one check among the probes, and the seed of their draws.
PROBES_OF_A_CHECK, PROBE_SEED = 8, 20
#: Programs of a grading: the student's and the solution's.
LAUNCHES = 2
#: Answers of a program to the probes.
Fingerprint = tuple[str, ...]


class SolutionFault(Exception):
    """The author's solution failed where it must answer: our fault for a student, the author's to mend."""


@dataclass(frozen=True)
class DeclaredGrader:
    """Grades one declared exercise; `fingerprints` are those of its known mistakes, where they were made before."""

    exercise: str
    declaration: Declaration
    folder: Path | None = None
    fingerprints: Mapping[str, Fingerprint] | None = None
    _made: dict[str, Mapping[str, Fingerprint]] = field(default_factory=dict, repr=False, compare=False)
    _making: threading.Lock = field(default_factory=threading.Lock, repr=False, compare=False)

    @property
    def solution(self) -> str:
        return self.declaration.solution

    @property
    def functions(self) -> tuple[str, ...]:
        return self.declaration.functions

    def kit(self, seed: int) -> KitSettings:
        """Return the kit of a program: the driver plays the calls of the exercise's functions."""
        drawn = int(stream(seed, "kit").integers(2**62))
        whole: dict[str, Value] = {"whole_program": self.functions[0]} if self.declaration.is_program else {}
        return KitSettings(SCENARIOS, {"seed": drawn, "functions": self.functions, **whole})

    def grade(
        self,
        source: bytes,
        programs: Programs,
        *,
        seed: int,
        version: str,
        while_naming: WhileNaming = no_early_verdict,
    ) -> Judgement:
        """Return the judgement of a file; see `Grader.grade`. Raises SolutionFault where the solution fails."""
        started = time.perf_counter()
        kit = self.kit(seed)
        cases = {check.id: self.cases(check, seed) for check in self.declaration.checks}
        if isinstance(programs, PreparablePrograms):
            programs.prepare(self.solution.encode(), kit, LAUNCHES)
        student, solution = Player(programs, source, kit), Player(programs, self.solution.encode(), kit)
        try:
            findings = shorten_repeated_reasons(
                self._judge_file(source, student, solution, cases, clock_of_programs(programs))
            )
            stdout = student.stdout()
            checked = time.perf_counter()
            diagnosis = None
            if any(not finding.passed for finding in findings) and self.declaration.mistakes and student.functions:
                early = make_verdict(self.exercise, version, seed, findings, None, stdout=stdout, timings={})
                with while_naming(Judgement(early)):
                    diagnosis = self._name_known_mistake(findings, student, programs) or slip_diagnosis(findings)
        finally:
            student.close()
            solution.close()
        ended = time.perf_counter()
        timings = {"checks_ms": checked - started, "diagnosis_ms": ended - checked, "total_ms": ended - started}
        milliseconds = {name: round(1000.0 * seconds, 3) for name, seconds in timings.items()}
        verdict = make_verdict(self.exercise, version, seed, findings, diagnosis, stdout=stdout, timings=milliseconds)
        return Judgement(verdict, {each.result.id: each.figure for each in findings if each.figure is not None})

    def cases(self, check: DeclaredCheck, seed: int) -> list[Case]:
        """Return the cases of a check: by hand, then drawn from the seed."""
        drawn = check.drawn.draw(stream(seed, check.id)) if check.drawn else ()
        return [*map(Case, check.cases), *(Case(each.scenario, each) for each in drawn)]

    def _judge_file(
        self,
        source: bytes,
        student: Player,
        solution: Player,
        cases: Mapping[str, Sequence[Case]],
        clock: Callable[[], float],
    ) -> list[Finding]:
        checks = self.declaration.checks
        scenarios = [case.scenario for check in checks for case in cases[check.id]]
        try:
            got = student.start(scenarios)
        except StudentFault as fault:
            return [fault_finding(check, fault) for check in checks]
        right = self._play_solution(solution, cases)
        broken = next(filter(None, (rule.find_breach(source) for rule in self.declaration.rules)), None)
        findings, at = [], 0
        for check in checks:
            span = slice(at, at + len(cases[check.id]))
            at = span.stop
            if broken is not None:
                findings.append(failed_finding(check, broken[0], sign=broken[0], got="interdit par l’énoncé"))
                continue
            trios = zip(cases[check.id], right[span], got[span], strict=True)
            failure = next(filter(None, (judge(check, *trio) for trio in trios)), None)
            if failure is None:
                findings.append(Finding(CheckResult(check.id, check.title, True, check.points, check.points)))
                continue
            simplest = self.find_simplest_failure(check, failure, student, solution, clock, clock() + SIMPLER_SECONDS)
            findings.append(self.describe_failure(check, *replay_failure_alone(check, simplest, source, student)))
        return findings

    def _play_solution(self, solution: Player, cases: Mapping[str, Sequence[Case]]) -> list[PlayedScenario]:
        """Return what the solution does in each case. Raises SolutionFault where it is not what the author says."""
        pairs = [(check, case.scenario) for check in self.declaration.checks for case in cases[check.id]]
        right = solution.play([scenario for _, scenario in pairs])
        for (check, scenario), played in zip(pairs, right, strict=True):
            if not is_answered(played):
                raise SolutionFault(f"{scenario.text()} : {played.fault.message if played.fault else ''}")
            last = len(scenario.statements) - 1
            if scenario.expected and not gives_expected_value(
                check.with_tolerance_of_case(scenario), scenario.expected[0], played, last
            ):
                given = observed_value(check, played, last)
                wanted, obtained = python_text_pair(scenario.expected[0], given)
                raise SolutionFault(f"{scenario.text()} : la solution donne {obtained}, et « attendus » dit {wanted}")
        return right

    def find_simplest_failure(
        self,
        check: DeclaredCheck,
        failure: FailedCase,
        student: Player,
        solution: Player,
        clock: Callable[[], float],
        until: float,
    ) -> FailedCase:
        """Return the simplest failure found from one, within bounds; the same kind of failure throughout."""
        left = MAX_SIMPLER
        while failure.case.drawn is not None and check.drawn is not None and left > 0 and clock() < until:
            if failure.got.fault is not None and failure.got.fault.fatal:
                break
            simpler = check.drawn.iter_simpler_cases(failure.case.drawn)
            batch = [
                Case(each.scenario, each) for each, _ in zip(simpler, range(min(left, SIMPLER_AT_ONCE)), strict=False)
            ]
            left -= len(batch)
            scenarios = [case.scenario for case in batch]
            right = solution.play(scenarios) if batch else []
            trios = zip(batch, right, student.play(scenarios) if batch else [], strict=True)
            judged = (judge(check, *trio) for trio in trios if is_answered(trio[1]))
            better = next((other for other in judged if other is not None and fails_alike(failure, other)), None)
            if better is None:
                break
            failure = better
        return failure

    def describe_failure(self, check: DeclaredCheck, failure: FailedCase, note: str = "") -> Finding:
        """Return the finding of a failing case; `note` ends its words."""
        scenario, fault = failure.case.scenario, failure.got.fault
        statement = scenario.statements[min(failure.step, len(scenario.statements) - 1)]
        inputs = self._counterexample_inputs(scenario)
        expected = observed_value(check, failure.right, failure.step)
        if failure.mismatch is None:
            assert fault is not None
            found = fault_finding(check, fault, inputs=inputs, expected=expected, case=scenario)
            message = "\n".join(filter(None, (found.result.message, note)))
            return replace(found, result=replace(found.result, message=message))
        got = observed_value(check, failure.got, failure.step)
        message = failure_message(check, failure, statement, python_text_pair(expected, got))
        return failed_finding(
            check,
            " ".join(filter(None, (message, failure.mismatch.message, note))),
            inputs=inputs,
            expected=expected,
            got=got,
            cause=failure.mismatch.cause,
            slip=failure.mismatch.slip,
            figure=describe_figure(statement.callee or scenario.called_program_name, expected, got),
            case=scenario,
        )

    def _counterexample_inputs(self, scenario: Scenario) -> dict[str, Value]:
        """Return what a counterexample gives: the arguments by name for one call of a function, else the whole case."""
        given: dict[str, Value] = {}
        first = scenario.statements[0]
        names = self.parameters_by_function.get(first.callee, ())
        if scenario.runs_program:
            given = {"ce que l’on tape": list(scenario.typed_lines or ())}
        elif len(scenario.statements) == 1 and len(first.arguments) <= len(names) and not first.named:
            given = dict(zip(names, first.arguments, strict=False))
        else:
            given = {"cas": Reference(scenario.text())}
        if scenario.lines:
            given["lignes lues"] = list(scenario.lines)
        given |= {f"fichier {name}": text for name, text in scenario.files}
        return given

    @cached_property
    def parameters_by_function(self) -> dict[str, tuple[str, ...]]:
        """The names of the parameters of the solution's functions."""
        return {
            node.name: tuple(argument.arg for argument in (*node.args.posonlyargs, *node.args.args))
            for node in parse_source(self.solution).body
            if isinstance(node, ast.FunctionDef)
        }

    def find_solution_fault(self, programs: Programs, seed: int) -> str:
        """Return why the solution does not answer as it must, for its author; empty where it does."""
        player = Player(programs, self.solution.encode(), self.kit(seed))
        try:
            self._play_solution(player, {check.id: self.cases(check, seed) for check in self.declaration.checks})
        except SolutionFault as fault:
            return str(fault)
        finally:
            player.close()
        return ""

    def find_failing_case(self, result: CheckResult) -> Scenario | None:
        """Return the case that shows why a check failed, None where it cannot be played again."""
        check = next((each for each in self.declaration.checks if each.id == result.id), None)
        if check is None or result.passed or not result.case:
            return None
        written = next((case for case in check.cases if case.exact_text() == result.case), None)
        try:
            imports = self.declaration.imported_names
            return written or Scenario(parse_scenario(result.case, self.functions, imports=imports))
        except MalformedDeclaration:
            return None

    def probes(self) -> list[Scenario]:
        """Return the scenarios by whose answers mistakes are known: the same for every seed."""
        return [case.scenario for _, case in self.probe_cases()]

    def probe_cases(self) -> list[tuple[DeclaredCheck, Case]]:
        """Return the cases of the probes, with their checks."""
        return [
            (check.with_tolerance_of_case(case.scenario), case)
            for check in self.declaration.checks
            for case in (
                *map(Case, check.cases),
                *self.cases(replace(check, cases=()), PROBE_SEED)[:PROBES_OF_A_CHECK],
            )
        ]

    def make_fingerprints(self, programs: Programs) -> dict[str, Fingerprint]:
        """Run the known mistakes on the probes, behind the walls; return their answers, exceptions and time-outs."""
        return {
            mistake.id: self.fingerprint(mistake.program.encode(), programs) for mistake in self.declaration.mistakes
        }

    def fingerprint(self, source: bytes, programs: Programs) -> Fingerprint:
        """Return what a file answers to the probes."""
        player = Player(programs, source, self.kit(PROBE_SEED))
        try:
            return tuple(map(probe_answer, player.play(self.probes())))
        finally:
            player.close()

    def _fingerprints_of_known_mistakes(self, programs: Programs) -> Mapping[str, Fingerprint]:
        if self.fingerprints is not None:
            return self.fingerprints
        with self._making:
            if "mistakes" not in self._made:
                self._made["mistakes"] = self.make_fingerprints(programs)
        return self._made["mistakes"]

    def _name_known_mistake(self, findings: Sequence[Finding], student: Player, programs: Programs) -> Diagnosis | None:
        """Return the known mistake that answers every probe as the student's file does, within the tolerances."""
        answers = tuple(map(probe_answer, student.play_again(self.probes())))
        known, checks = self._fingerprints_of_known_mistakes(programs), [check for check, _ in self.probe_cases()]
        mistake = find_mistake(self.declaration.mistakes, known, answers, checks)
        if mistake is None:
            return None
        explains = tuple(finding.result.id for finding in findings if not finding.passed)
        words = f"{mistake.explanation}\n\n{mistake.question}"
        return Diagnosis(mistake.id, mistake.title, words, explains=(explains,), certain=True)

    def warm_up(self) -> None:
        """Nothing is slow the first time: no code of the author runs here."""

    def mistake_ids(self) -> frozenset[str]:
        return frozenset(mistake.id for mistake in self.declaration.mistakes)

    def known_submissions(self) -> Iterator[KnownSubmission]:
        """Yield the solution, the mistakes and the specimens, with their expected verdicts."""
        yield KnownSubmission("référence", _same_source_for_all_seeds(self.solution.encode()), Outcome.OK)
        for mistake in self.declaration.mistakes:
            yield KnownSubmission(
                f"erreur {mistake.id}", _same_source_for_all_seeds(mistake.program.encode()), diagnosis=mistake.id
            )
        for specimen in self.specimens():
            subject = f"spécimen {specimen.outcome.value}/{specimen.path.name}"
            yield KnownSubmission(subject, _same_source_for_all_seeds(specimen.path.read_bytes()), specimen.outcome)

    def specimens(self) -> Iterator[Specimen]:
        """Yield the submissions under `specimens/<outcome>/`. Raises MalformedExerciseError."""
        return read_specimens(self.folder) if self.folder else iter(())


def _same_source_for_all_seeds(source: bytes) -> Callable[[int], bytes]:
    return lambda _seed: source
