"""Grading of code: from a file and a seed to a verdict, the same for the same seed."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path

import numpy as np

from graders.core.code.bench import Bench
from graders.core.code.checks import Check
from graders.core.code.diagnosis import combine_diagnoses, diagnose, slip_diagnosis
from graders.core.code.folder import Misconception, Specimen, read_specimens
from graders.core.code.prober import Prober, RecognisedMistakes
from graders.core.code.reenacting import Reenactor
from graders.core.code.runner import DEFAULT_BUDGET, Runner
from graders.core.code.running import run_check, run_checks
from graders.core.compare.shrinking import Budget
from graders.core.compare.slips import SLIPS
from graders.core.contract.films import film_to_json
from graders.core.contract.findings import Finding, Judgement, make_verdict
from graders.core.contract.local import LOCAL
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, Programs, StudentFault
from graders.core.contract.protocol import KnownSubmission
from graders.core.contract.streams import stream
from graders.core.contract.verdict import Diagnosis

JUDGED = (Outcome.WRONG_ANSWER, Outcome.INVALID_OUTPUT)
#: What may have a misconception for its cause: a program that runs, though it raises on some inputs.
DIAGNOSED = (*JUDGED, Outcome.RUNTIME_ERROR)
#: The slip that is told beside any other mistake.
MODIFIED_ARGUMENT = "argument_modifie"
KitMaker = Callable[[np.random.Generator], KitSettings]
FRESH_REENACTOR = Reenactor()
#: What a counterexample that nobody reads may cost.
NO_SHRINKING = Budget(calls=0)


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
    reenactor: Reenactor = FRESH_REENACTOR
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
            findings = self._findings(runner, kit, seed, source)
            checked = time.perf_counter()
            diagnosis = self._diagnosis(findings, runner, kit, seed)
        finally:
            runner.close()
        ended = time.perf_counter()
        timings = {"checks_ms": (started, checked), "diagnosis_ms": (checked, ended), "total_ms": (started, ended)}
        verdict = make_verdict(
            self.exercise,
            version,
            seed,
            findings,
            diagnosis,
            stdout=runner.stdout,
            timings={name: round(1000.0 * (end - start), 3) for name, (start, end) in timings.items()},
        )
        figures = {f.result.id: f.figure for f in findings if f.figure is not None}
        films = {check: film for check, data in runner.films.items() if (film := film_to_json(data)) is not None}
        return Judgement(verdict, figures, films)

    def _findings(self, runner: Runner, kit: KitSettings, seed: int, source: bytes) -> Sequence[Finding]:
        """What names a mistake is asked of the same program where this is seen to keep nothing of what it was asked;
        else of one launched afresh, which comes up while the checks go on."""
        prober = self.prober
        if prober is None:
            return run_checks(self.checks, runner, kit, seed)
        steady = cache(lambda: prober.is_stateless(source, kit))
        return run_checks(
            self.checks, runner, kit, seed,
            launches_if_failed=lambda: 0 if steady() else 1,
            beside=lambda failed: prober.planned_calls(*self._asked_of(failed)) if steady() else (),
        )  # fmt: skip

    def first_failed(
        self, source: bytes, programs: Programs, *, seed: int, checks: Sequence[Check] | None = None
    ) -> str | None:
        """The id of the first check that a file fails as `grade` would, None at full marks. Nothing is simplified nor
        named. `checks` are those of the exercise, in another order, or some of them.
        """
        kit = self.kit(stream(seed, "kit"))
        runner = Runner(programs, source, kit, budget=NO_SHRINKING)
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
        failed = [check for check, _ in pairs]
        blamed, (asked, alone) = _blamed(failed), self._asked_of(failed)
        ids, last, follow = self.prober.recognise(runner, asked, alone) if self.prober else RecognisedMistakes()
        left = (alone if ids else blamed) - set(follow)
        ids = (*ids, *self._reenacted(ids, left, runner, kit, seed)) or last
        if ids:
            touched = {MODIFIED_ARGUMENT} & {finding.slip for _, finding in pairs} - set(ids)
            return combine_diagnoses((*ids, *touched), self.misconceptions)
        return slip_diagnosis(
            [(c.functions, f.slip) for c, f in pairs if f.cause in JUDGED and f.result.counterexample]
        )

    def _asked_of(self, failed: Sequence[Check]) -> tuple[Sequence[str], set[str]]:
        """The functions that are asked what names a mistake, and those that failed a check of their own."""
        blamed = _blamed(failed)
        asked = [function for function in self.functions if function in blamed]
        return asked, {check.functions[0] for check in failed if len(check.functions) == 1}

    def _reenacted(
        self,
        found: Sequence[str],
        blamed: Collection[str],
        runner: Runner,
        kit: KitSettings,
        seed: int,
    ) -> Sequence[str]:
        """What the observations say of the functions of which no mistake was found, by misconceptions that are no
        edit."""
        told = {function for m in self.misconceptions if m.id in found for function in m.functions}
        left = set() if set(found) & SLIPS.keys() else set(blamed) - told
        others = [m for m in self.misconceptions if not (m.edited or m.ruled) and left & set(m.functions)]
        if not others:
            return []
        reenact = partial(self.reenactor.reenact, checks=self.checks, kit=kit, seed=seed)
        named = diagnose(runner.observations, others, reenact)
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

    def mistake_ids(self) -> frozenset[str]:
        """The ids of the misconceptions."""
        return frozenset(misconception.id for misconception in self.misconceptions)

    def known_submissions(self) -> Iterator[KnownSubmission]:
        """The solution, the catalogued mistakes, the specimens."""
        yield KnownSubmission("référence", _always(self.solution.encode()), Outcome.OK)
        for misconception in self.misconceptions:
            source = _always(misconception.source.encode())
            yield KnownSubmission(f"erreur {misconception.id}", source, diagnosis=misconception.id)
        for specimen in self.specimens():
            subject = f"spécimen {specimen.outcome.value}/{specimen.path.name}"
            yield KnownSubmission(subject, _always(specimen.path.read_bytes()), specimen.outcome)

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
