"""Closed loops: a program is run again and again on hidden runs, each in a process of its own, until it is decided.

The runs are the same for everybody; only the program's own draws differ from one grading to another. A loop costs
seconds where a check of one call costs milliseconds: it waits for the checks with which it would fail for sure
(`after`), stops as soon as the runs left cannot change what it finds, and at the first run that exhausts a limit.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, StudentFault

#: Seconds of a clock after which no other run is begun, well below what a grading may take.
MAX_TOTAL_SECONDS = 240.0


@dataclass
class Run:
    """One run as it goes: its number from 0, the bench of its own process, the step that it has come to, and who makes
    a film of it as far as it went."""

    number: int
    bench: Bench
    step: int = 0
    make_film: Callable[[], FigureData] | None = None

    @property
    def film(self) -> FigureData | None:
        return None if self.make_film is None else self.make_film()

    @property
    def location_text(self) -> str:
        return f"Essai {self.number + 1}" + (f", pas {self.step}" if self.step else "")


#: Plays one run: returns when it succeeds; raises Rejection, or lets a StudentFault through, when it does not.
Play = Callable[[Run], None]


@dataclass(frozen=True)
class FailedRun:
    """Why a run failed, and where."""

    run: Run
    reason: Rejection | StudentFault


@dataclass
class RunTally:
    """The runs so far: how many succeeded, why the others did not, and who makes the film that is kept of one of them:
    only that one is made."""

    succeeded: int = 0
    failures: list[FailedRun] = field(default_factory=list)
    make_film: Callable[[], FigureData] | None = None
    stopped: bool = False

    @property
    def played(self) -> int:
        return self.succeeded + len(self.failures)

    @property
    def representative_failure(self) -> FailedRun:
        """What is told of the failures: a fault, which its author can mend first, before a run that was lost."""
        faults = [one for one in self.failures if isinstance(one.reason, StudentFault)]
        return (faults or self.failures)[0]


@dataclass(frozen=True, kw_only=True)
class ClosedLoop(Check):
    """`needed` of the `runs` must succeed. `kits` are the settings of the process of each run, but for its seed.

    The film kept is that of the first run that failed, else of the last one. A mistake that is re-enacted plays no
    run: no observation here tells one mistake from another.
    """

    runs: int
    needed: int
    kit: Callable[[Bench, int], KitSettings]
    play: Play
    after: tuple[str, ...] = ()
    seconds: float = MAX_TOTAL_SECONDS

    def run(self, bench: Bench) -> None:
        if bench.runner.reenacting:
            return
        if bench.runner.failed.intersection(self.after):
            raise self._waits()
        tally = self._tally(bench)
        if tally.make_film is not None:
            counts = {"runs": self.runs, "needed": self.needed, "succeeded": tally.succeeded}
            bench.film({**tally.make_film(), **counts})
        bench.observe(self.id, tally.succeeded >= self.needed, ok=tally.succeeded >= self.needed)
        if tally.succeeded < self.needed:
            raise self._told(tally)

    def _tally(self, bench: Bench) -> RunTally:
        """Play runs until it is decided."""
        tally, deadline = RunTally(), time.monotonic() + self.seconds
        for number in range(self.runs):
            if time.monotonic() > deadline:
                tally.stopped = True
                break
            run = Run(number, bench)
            why = self._why(run)
            if run.make_film is not None and not tally.failures:
                tally.make_film = run.make_film
            if why is None:
                tally.succeeded += 1
            else:
                tally.failures.append(FailedRun(run, why))
            if tally.succeeded >= self.needed or len(tally.failures) > self.runs - self.needed:
                break
            if isinstance(why, StudentFault) and why.fatal:
                break
        return tally

    def _why(self, run: Run) -> Rejection | StudentFault | None:
        """Play a run in a process of its own; why it failed, if it did."""
        try:
            with run.bench.on(self.kit(run.bench, run.number)) as own:
                run.bench = own
                self.play(run)
        except (Rejection, StudentFault) as why:
            return why
        return None

    def _waits(self) -> Rejection:
        return Rejection(
            "Ces essais en boucle ne sont pas lancés : une vérification plus simple échoue déjà, dont ils dépendent. "
            "Réussissez-la d'abord.",
            inputs={},
            expected="les vérifications d'un seul pas réussies",
            got="une d'elles au moins échoue",
        )

    def _told(self, tally: RunTally) -> Rejection:
        if tally.stopped or not tally.failures:
            return self._too_long(tally)
        run, why = tally.representative_failure.run, tally.representative_failure.reason
        told = fault_rejection(why, inputs={}) if isinstance(why, StudentFault) else why
        won = {0: "aucun n'est réussi", 1: "un seul est réussi"}.get(tally.succeeded, f"{tally.succeeded} sont réussis")
        count = f"Il faut {self.needed} essais réussis sur {self.runs} ; des {tally.played} joués, {won}."
        message, *frames = told.message.split("\n")
        return Rejection(
            "\n".join((f"{run.location_text} : {message} {count}", *frames)),
            inputs={"essai": run.number + 1, **(told.inputs or {})},
            expected=told.expected,
            got=told.got,
            slip=told.slip,
            cause=told.cause,
            figure=told.figure,
        )

    def _too_long(self, tally: RunTally) -> Rejection:
        return Rejection(
            f"Les essais ont duré plus de {self.seconds:.0f} s : {tally.played} seulement ont été joués sur "
            f"{self.runs}.",
            inputs={},
            expected=f"{self.needed} essais réussis",
            got=f"{tally.succeeded}",
            cause=Outcome.TIMEOUT,
        )
