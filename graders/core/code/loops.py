"""Closed loops: a program plays hidden runs, each in a process of its own, until the result is decided.

The runs are the same for everybody; only the program's random numbers differ between gradings. A loop costs seconds, a
check of one call milliseconds: it is skipped when a check on which it depends has failed (`after`), and stops when the
remaining runs cannot change the result, or a run exhausts a limit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from graders.core.code.bench import Bench
from graders.core.code.checks import Check, Rejection, fault_rejection
from graders.core.contract.findings import FigureData
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, StudentFault

#: Seconds of the programs' clock after which no other run is started, well below the limit of a grading.
MAX_TOTAL_SECONDS = 240.0


@dataclass
class ClosedLoopRun:
    """One run: its number from 0, the bench of its own process, its current step, and the maker of its film so far."""

    number: int
    bench: Bench
    step: int = 0
    make_film: Callable[[], FigureData] | None = None

    @property
    def film(self) -> FigureData | None:
        return None if self.make_film is None else self.make_film()

    @property
    def run_and_step_text(self) -> str:
        """« Essai 3, pas 12 »; the run alone before its first step."""
        return f"Essai {self.number + 1}" + (f", pas {self.step}" if self.step else "")


#: Plays one run: returns when it succeeds; raises Rejection or StudentFault when it does not.
Play = Callable[[ClosedLoopRun], None]


@dataclass(frozen=True)
class FailedRun:
    """A failed run and the reason."""

    run: ClosedLoopRun
    reason: Rejection | StudentFault


@dataclass
class RunTally:
    """The runs so far: number of successes, failures, and the maker of the one film that is kept."""

    succeeded: int = 0
    failures: list[FailedRun] = field(default_factory=list)
    make_film: Callable[[], FigureData] | None = None
    stopped: bool = False

    @property
    def played(self) -> int:
        return self.succeeded + len(self.failures)

    @property
    def representative_failure(self) -> FailedRun:
        """The failure to report: the first fault of the program, else the first lost run."""
        faults = [failure for failure in self.failures if isinstance(failure.reason, StudentFault)]
        return (faults or self.failures)[0]


@dataclass(frozen=True, kw_only=True)
class ClosedLoop(Check):
    """`needed` of the `runs` must succeed. `kit` gives the settings of each run's process, without its seed.

    The film is that of the first failed run, else of the last one. Re-enacted mistakes play no run: the observations
    here do not distinguish mistakes.
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
            raise self._dependency_rejection()
        tally = self._play_runs(bench)
        if tally.make_film is not None:
            counts = {"runs": self.runs, "needed": self.needed, "succeeded": tally.succeeded}
            bench.record_film({**tally.make_film(), **counts})
        bench.observe(self.id, tally.succeeded >= self.needed, ok=tally.succeeded >= self.needed)
        if tally.succeeded < self.needed:
            raise self._failure_rejection(tally)

    def _play_runs(self, bench: Bench) -> RunTally:
        """Play runs until the result is decided."""
        clock = bench.runner.clock
        tally, deadline = RunTally(), clock() + self.seconds
        for number in range(self.runs):
            if clock() > deadline:
                tally.stopped = True
                break
            run = ClosedLoopRun(number, bench)
            why = self._failure_reason(run)
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

    def _failure_reason(self, run: ClosedLoopRun) -> Rejection | StudentFault | None:
        """Play a run in a process of its own, and return the reason of its failure, if any."""
        try:
            with run.bench.run_with_kit(self.kit(run.bench, run.number)) as own:
                run.bench = own
                self.play(run)
        except (Rejection, StudentFault) as why:
            return why
        return None

    def _dependency_rejection(self) -> Rejection:
        return Rejection(
            "Ces essais en boucle ne sont pas lancés : une vérification plus simple échoue déjà, dont ils dépendent. "
            "Réussissez-la d'abord.",
            inputs={},
            expected="les vérifications d'un seul pas réussies",
            got="une d'elles au moins échoue",
            neutral=True,
        )

    def _failure_rejection(self, tally: RunTally) -> Rejection:
        if tally.stopped or not tally.failures:
            return self._timeout_rejection(tally)
        run, why = tally.representative_failure.run, tally.representative_failure.reason
        rejection = fault_rejection(why, inputs={}) if isinstance(why, StudentFault) else why
        won = {0: "aucun n'est réussi", 1: "un seul est réussi"}.get(tally.succeeded, f"{tally.succeeded} sont réussis")
        count = f"Il faut {self.needed} essais réussis sur {self.runs} ; des {tally.played} joués, {won}."
        message, *frames = rejection.message.split("\n")
        return Rejection(
            "\n".join((f"{run.run_and_step_text} : {message} {count}", *frames)),
            inputs={"essai": run.number + 1, **(rejection.inputs or {})},
            expected=rejection.expected,
            got=rejection.got,
            slip=rejection.slip,
            cause=rejection.cause,
            figure=rejection.figure,
        )

    def _timeout_rejection(self, tally: RunTally) -> Rejection:
        return Rejection(
            f"Les essais ont duré plus de {self.seconds:.0f} s : {tally.played} seulement ont été joués sur "
            f"{self.runs}.",
            inputs={},
            expected=f"{self.needed} essais réussis",
            got=f"{tally.succeeded}",
            cause=Outcome.TIMEOUT,
        )
