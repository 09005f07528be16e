"""Closed loops: stopped as soon as they are decided, told by what went wrong first, filmed where they failed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from graders.core.code.bench import Bench
from graders.core.code.checks import Rejection
from graders.core.code.loops import ClosedLoop, ClosedLoopRun
from graders.core.code.runner import Runner
from graders.core.contract.local import LocalProgram
from graders.core.contract.outcomes import Outcome
from graders.core.contract.program import KitSettings, PlannedCalls, Program, StudentFault

KIT = KitSettings("l20", {"libres": None, "portee_max": 12.0, "seed": 0})


class Programs:
    """Starts programs of this process, and counts them."""

    def __init__(self) -> None:
        self.opened: list[KitSettings] = []

    def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
        self.opened.append(kit)
        return LocalProgram(source, kit)


def play(run: ClosedLoopRun) -> None:
    """The program says, from the number of the run, whether it succeeds."""
    run.make_film = lambda: {"kind": "essai", "number": run.number}
    run.step = 2
    if not run.bench.call("essai", run.number):
        raise Rejection("le robot est perdu.", inputs={"x": 1.0}, expected=2, got=3)


LOOP = ClosedLoop(
    id="boucle", title="…", points=4, functions=("essai",), hint="?", runs=8, needed=6,
    kit=lambda bench, number: replace(KIT, parameters={**KIT.parameters, "seed": number}), play=play,
)  # fmt: skip


def ran(
    body: str, loop: ClosedLoop = LOOP, programs: Programs | None = None, **about: Any
) -> tuple[Runner, Programs, Rejection | None]:
    """What comes of the loop for a program whose function has this body."""
    programs = programs or Programs()
    runner = Runner(programs, f"def essai(k):\n    {body}\n".encode(), KIT, **about)
    try:
        loop.run(Bench("boucle", runner, np.random.default_rng(0), KIT))
    except Rejection as rejection:
        return runner, programs, rejection
    return runner, programs, None


def test_runs_stop_as_soon_as_enough_have_succeeded() -> None:
    runner, programs, rejection = ran("return True")
    assert rejection is None
    assert [kit.parameters["seed"] for kit in programs.opened] == list(range(6))
    assert runner.films["boucle"]["number"] == 5


def test_a_run_or_two_may_fail_and_the_first_of_them_is_filmed() -> None:
    runner, programs, rejection = ran("return k not in (1, 4)")
    assert rejection is None
    assert len(programs.opened) == 8
    assert runner.films["boucle"]["number"] == 1


def test_runs_stop_as_soon_as_too_many_have_failed() -> None:
    runner, programs, rejection = ran("return k > 4")
    assert rejection is not None
    assert len(programs.opened) == 3
    assert rejection.message == (
        "Essai 1, pas 2 : le robot est perdu. Il faut 6 essais réussis sur 8 ; des 3 joués, aucun n'est réussi."
    )
    assert rejection.inputs == {"essai": 1, "x": 1.0}
    assert [(one.function, one.ok) for one in runner.observations] == [("boucle", False)]


@pytest.mark.parametrize("body", ["return [1][k + 1]", "return k > 0 or [][0]", "return k == 1 and [][0]"])
def test_an_exception_is_told_as_such_before_a_run_that_was_lost(body: str) -> None:
    """Always, in the first run alone, or after one that was lost; one fault is one run that failed."""
    _, _, rejection = ran(body, replace(LOOP, needed=8))
    if body.startswith("return k == 1"):
        assert rejection is not None
        assert rejection.cause is Outcome.WRONG_ANSWER  # the first run decides, nothing has been raised yet
        _, _, rejection = ran(body)
    assert rejection is not None
    assert rejection.cause is Outcome.RUNTIME_ERROR
    assert "IndexError" in rejection.message


def test_a_program_that_exhausts_a_limit_is_not_run_again() -> None:
    class Slow(LocalProgram):
        def call(self, function: str, *args: Any, return_arguments: bool = False) -> Any:
            raise StudentFault(Outcome.TIMEOUT, "temps dépassé", fatal=True)

    class SlowPrograms(Programs):
        def open(self, source: bytes, kit: KitSettings, ahead: Sequence[PlannedCalls] = ()) -> Program:
            self.opened.append(kit)
            return Slow(source, kit)

    programs = SlowPrograms()
    runner = Runner(programs, b"def essai(k):\n    return True\n", KIT)
    with pytest.raises(Rejection) as told:
        LOOP.run(Bench("boucle", runner, np.random.default_rng(0), KIT))
    assert told.value.cause is Outcome.TIMEOUT
    assert len(programs.opened) == 1


def test_a_loop_waits_for_the_checks_that_it_depends_on() -> None:
    programs = Programs()
    runner = Runner(programs, b"def essai(k):\n    return True\n", KIT)
    runner.failed.add("pas")
    with pytest.raises(Rejection, match="ne sont pas lancés"):
        replace(LOOP, after=("pas",)).run(Bench("boucle", runner, np.random.default_rng(0), KIT))
    assert not programs.opened


def test_a_mistake_that_is_reenacted_plays_no_run() -> None:
    runner, programs, rejection = ran("return False", reenacting=True)
    assert rejection is None
    assert not programs.opened
    assert not runner.observations


class TimedPrograms(Programs):
    """Programs by whose clock a run takes `seconds`."""

    def __init__(self, seconds: float) -> None:
        super().__init__()
        self._seconds = seconds

    def clock(self) -> float:
        return self._seconds * len(self.opened)


@pytest.mark.parametrize(("seconds", "runs"), [(130.0, 2), (0.0, 6)])
def test_runs_that_last_too_long_by_the_clock_of_their_programs_are_begun_no_more(seconds: float, runs: int) -> None:
    """The clock of programs that are stopped stands still."""
    programs = TimedPrograms(seconds)
    runner, _, rejection = ran("return True", programs=programs)
    assert len(programs.opened) == runs
    assert (None if rejection is None else rejection.cause) == (Outcome.TIMEOUT if seconds else None)
    assert runner.seconds_per_call == seconds
