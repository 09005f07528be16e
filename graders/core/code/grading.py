"""Grading of code: from a file and a seed to a verdict, the same for the same seed."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.code.diagnosis import combined, diagnose, slip_diagnosis
from graders.core.code.folder import Misconception, Specimen, read_specimens
from graders.core.code.prober import Prober
from graders.core.code.reenacting import Reenactor
from graders.core.code.runner import DEFAULT_BUDGET, Observation, Runner
from graders.core.code.simplifying import Unsimplified, run_alone, simplify
from graders.core.compare.shrinking import Budget
from graders.core.compare.slips import SLIPS
from graders.core.compare.words import tidy, to_jsonable, whole_jsonable
from graders.core.contract.films import plain
from graders.core.contract.findings import Finding, Judgement, verdict_of
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import Foreseen, KitSettings, Programs, StudentFault
from graders.core.contract.protocol import Known
from graders.core.contract.streams import stream
from graders.core.contract.verdict import CheckResult, Counterexample, Diagnosis

FIGURE_ITEMS = 20_000
JUDGED = (Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT)
#: What may have a misconception for its cause: a program that runs, though it raises on some inputs.
DIAGNOSED = (*JUDGED, Outcome.RUNTIME_ERROR)
#: The slip that is told beside any other mistake.
TOUCHED = "argument_modifie"
KitMaker = Callable[[np.random.Generator], KitSettings]
FRESH = Reenactor()
#: What a counterexample that nobody reads may cost.
UNSIMPLIFIED = Budget(calls=0)


@dataclass(frozen=True)
class CodeGrader:
    """Grades one exercise of code, whose `functions` a submission writes; `folder` is the place of its grader.

    `reenactor` re-enacts its misconceptions; `budget` is what shrinking one counterexample may cost; `long` and
    `heavy` are as in `code`.
    """

    exercise: str
    folder: Path
    functions: tuple[str, ...]
    checks: tuple[Check, ...]
    kit: KitMaker
    misconceptions: tuple[Misconception, ...]
    solution: str
    reenactor: Reenactor = FRESH
    budget: Budget = DEFAULT_BUDGET
    prober: Prober | None = None
    long: bool = False
    heavy: bool = False

    def grade(self, source: bytes, programs: Programs, *, seed: int, version: str) -> Judgement:
        """The verdict of a file: every check is run on the program that `programs` starts of it.

        Whatever the student's program does ends in the verdict; an exception that leaves this is our own fault.
        """
        started = time.perf_counter()
        kit = self.kit(stream(seed, "kit"))
        runner = Runner(programs, source, kit, budget=self.budget)
        try:
            # What names a mistake asks a program launched afresh: it comes up while the checks go on.
            findings = run_checks(self.checks, runner, kit, seed, launches_if_failed=1 if self.prober else 0)
            checked = time.perf_counter()
            diagnosis = self._diagnosis(findings, runner, kit, seed)
        finally:
            runner.close()
        ended = time.perf_counter()
        timings = {"checks_ms": (started, checked), "diagnosis_ms": (checked, ended), "total_ms": (started, ended)}
        verdict = verdict_of(
            self.exercise,
            version,
            seed,
            findings,
            diagnosis,
            stdout=runner.stdout,
            timings={name: round(1000.0 * (end - start), 3) for name, (start, end) in timings.items()},
        )
        figures = {f.result.id: f.figure for f in findings if f.figure is not None}
        films = {check: film for check, data in runner.films.items() if (film := plain(data)) is not None}
        return Judgement(verdict, figures, films)

    def first_failed(
        self, source: bytes, programs: Programs, *, seed: int, checks: Sequence[Check] | None = None
    ) -> str | None:
        """The id of the first check that a file fails as `grade` would, None at full marks. Nothing is simplified nor
        named. `checks` are those of the exercise, in another order, or some of them.
        """
        kit = self.kit(stream(seed, "kit"))
        runner = Runner(programs, source, kit, budget=UNSIMPLIFIED)
        asked = self.checks if checks is None else checks
        try:
            _ = runner.program
            found = (run_check(check, Bench(check.id, runner, stream(seed, check.id), kit)) for check in asked)
            return next((finding.result.id for finding in found if not finding.passed), None)
        except StudentFault:
            return asked[0].id
        finally:
            runner.close()

    def _diagnosis(self, findings: Sequence[Finding], runner: Runner, kit: KitSettings, seed: int) -> Diagnosis | None:
        """The name of what failed: by the probes, else by re-enacting what these do not judge, else a usual slip."""
        pairs = [(check, finding) for check, finding in zip(self.checks, findings, strict=True) if not finding.passed]
        if not pairs or all(finding.cause not in DIAGNOSED for _, finding in pairs):
            return None
        blamed = _blamed([check for check, _ in pairs])
        asked = [function for function in self.functions if function in blamed]
        alone = {check.functions[0] for check, _ in pairs if len(check.functions) == 1}
        ids, last = self.prober.recognise(runner, asked, alone) if self.prober else ((), ())
        ids = (*ids, *self._reenacted(ids, alone if ids else blamed, runner.observations, kit, seed)) or last
        if ids:
            touched = {TOUCHED} & {finding.slip for _, finding in pairs} - set(ids)
            return combined((*ids, *touched), self.misconceptions)
        return slip_diagnosis(
            [(c.functions, f.slip) for c, f in pairs if f.cause in JUDGED and f.result.counterexample]
        )

    def _reenacted(
        self,
        found: Sequence[str],
        blamed: Collection[str],
        observations: Sequence[Observation],
        kit: KitSettings,
        seed: int,
    ) -> Sequence[str]:
        """What the observations say of the functions of which no mistake was found, by misconceptions that are no
        edit."""
        told = {function for m in self.misconceptions if m.id in found for function in m.functions}
        left = set() if set(found) & SLIPS.keys() else set(blamed) - told
        others = [m for m in self.misconceptions if not (m.edited or m.ruled) and left & set(m.functions)]
        named = diagnose(observations, others, partial(self.reenactor.reenact, checks=self.checks, kit=kit, seed=seed))
        return [named.id] if named else []

    def rehearse(self) -> None:
        """Grade the solution and a mistake in this process: what is imported and compiled at first use then is.

        Not what takes long to grade whether it is the first or not: what is saved then is nothing beside it.
        """
        if self.long:
            return
        mistakes = [mistake.source for mistake in self.misconceptions[:1]]
        for source in mistakes if self.heavy else (self.solution, *mistakes):
            self.grade(source.encode(), LOCAL, seed=0, version="")

    def mistakes(self) -> frozenset[str]:
        """The ids of the misconceptions."""
        return frozenset(misconception.id for misconception in self.misconceptions)

    def known(self) -> Iterator[Known]:
        """The solution, the catalogued mistakes, the specimens."""
        yield Known("référence", _always(self.solution.encode()), Outcome.OK)
        for misconception in self.misconceptions:
            source = _always(misconception.source.encode())
            yield Known(f"erreur {misconception.id}", source, diagnosis=misconception.id)
        for specimen in self.specimens():
            subject = f"spécimen {specimen.outcome.value}/{specimen.path.name}"
            yield Known(subject, _always(specimen.path.read_bytes()), specimen.outcome)

    def specimens(self) -> Iterator[Specimen]:
        """The submissions under `specimens/<outcome>/`. Raises MalformedExerciseError."""
        return read_specimens(self.folder)


def _blamed(failed: Sequence[Check]) -> frozenset[str]:
    """The functions that a failed check judges alone; where none does, all that a failed check judges.

    A check of several functions does not say which is at fault when another check does.
    """
    alone = [check for check in failed if len(check.functions) == 1]
    return frozenset(function for check in alone or failed for function in check.functions)


def _always(source: bytes) -> Callable[[int], bytes]:
    return lambda _seed: source


def run_checks(
    checks: Sequence[Check],
    runner: Runner,
    kit: KitSettings,
    seed: int,
    *,
    launches_if_failed: int = 0,
) -> list[Finding]:
    """What each of the checks finds of the runner's program, with the same draws for the same seed.

    Once one has failed, the file is about to be started so many times more.
    """
    benches = [Bench(check.id, runner, stream(seed, check.id), kit) for check in checks]
    found: list[Finding | Unsimplified] = []
    for begins, ends in _spans(checks):
        plan = _foreseen(checks[begins:ends], benches[begins:ends])
        if begins:
            runner.foresee(plan)
        else:
            try:
                runner.start(plan)
            except StudentFault as fault:
                return [_finding(check, fault_rejection(fault, inputs=None)) for check in checks]
            runner.expect(sum(check.launches for check in checks))
        for check, bench in zip(checks[begins:ends], benches[begins:ends], strict=True):
            found.append(_found(check, bench))
            if isinstance(found[-1], Unsimplified) or not found[-1].passed:
                if not runner.failed:
                    runner.expect(launches_if_failed)
                runner.failed.add(check.id)
    if failed := [one for one in found if isinstance(one, Unsimplified)]:
        runner.keep_what_was_printed()
        simplify(runner, failed, runner.answered)
    findings = [
        _told(check, one, bench) if isinstance(one, Unsimplified) else one
        for check, one, bench in zip(checks, found, benches, strict=True)
    ]
    return [_unless_alone(check, finding, checks, findings) for check, finding in zip(checks, findings, strict=True)]


def _spans(checks: Sequence[Check]) -> Iterator[tuple[int, int]]:
    """Checks in a row whose questions can go together: none but the last asks more than what is foreseen of it."""
    begins = 0
    for ends, check in enumerate(checks, 1):
        if check.asks_on or ends == len(checks):
            yield begins, ends
            begins = ends


def _foreseen(checks: Sequence[Check], benches: Sequence[Bench]) -> Sequence[Foreseen]:
    for check, bench in zip(checks, benches, strict=True):
        bench.foreseen = check.foreseen(bench)
    return [asked for bench in benches for asked in bench.foreseen]


def _unless_alone(check: Check, finding: Finding, checks: Sequence[Check], findings: Sequence[Finding]) -> Finding:
    """Take back the points of a check that any do-nothing function passes, when nothing else was earned."""
    others = [
        f
        for c, f in zip(checks, findings, strict=True)
        if not c.needs_another and set(c.functions) & set(check.functions)
    ]
    if not check.needs_another or not finding.passed or any(f.passed for f in others):
        return finding
    message = "Rien à reprocher ici, mais ces points ne comptent qu'à partir d'une autre vérification réussie."
    return _finding(
        check, Rejection(message, inputs={}, expected="une autre vérification réussie", got="aucune pour l'instant")
    )


def run_check(check: Check, bench: Bench) -> Finding:
    """Run one check and put what it found in words."""
    return _judged(check, lambda: run_alone(check.run, bench), bench)


def _found(check: Check, bench: Bench) -> Finding | Unsimplified:
    """As `run_check`, of one that does not simplify what it fails on."""
    try:
        return _judged(check, lambda: check.run(bench), bench)
    except Unsimplified as unsimplified:
        return unsimplified


def _told(check: Check, unsimplified: Unsimplified, bench: Bench) -> Finding:
    """What a check that has failed holds against the program, on the simplest input that was found."""

    def tell() -> None:
        raise unsimplified.rejection()

    return _judged(check, tell, bench)


def _judged(check: Check, run: Callable[[], None], bench: Bench) -> Finding:
    try:
        run()
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
    # A drawing of a part would be a drawing of something else.
    figure = None if rejection.figure is None else whole_jsonable(rejection.figure, limit=FIGURE_ITEMS)
    result = CheckResult(
        id=check.id,
        title=check.title,
        passed=False,
        points=0,
        max_points=check.points,
        message=rejection.message,
        counterexample=counterexample,
        hint=check.hint,
        figure=None if figure is None else check.id,
    )
    return Finding(result, rejection.cause, rejection.slip, figure)
