"""Programs that are stopped for a while: their limits do not pass meanwhile, and they cannot help it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from uuid import uuid4

import pytest

from server.sandbox import FaultKind, Policy, ProgramFault, Sandbox, SandboxFault
from server.sandbox.seat import Abandoned, SeatPrograms

POLICY = Policy(cpu_seconds=20.0, wall_seconds=1.5)
BRIEF = Policy(cpu_seconds=20.0, wall_seconds=0.3)
STOPPED_SECONDS = 1.6
MANY_CALLS = 2000
PROGRAM = b"""
import time

def attendre(secondes):
    time.sleep(secondes)
    return secondes

def boucler():
    while True:
        pass

def sourde():
    import signal
    for numero in range(1, 65):
        try:
            signal.signal(numero, signal.SIG_IGN)
        except (OSError, ValueError):
            pass
    boucler()

def tricher():
    import os, struct
    os.pwrite(229, struct.pack("<d", 1e9), os.fstat(229).st_size - 8)
    boucler()
"""


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox({}, POLICY) as sandbox:
        sandbox.warm()
        yield sandbox


@contextmanager
def seat_with_program(
    sandbox: Sandbox, policy: Policy = POLICY, stopped: float = STOPPED_SECONDS
) -> Iterator[tuple[SeatPrograms, Callable[..., object], list[threading.Timer]]]:
    """Yield a seat, the call of the program's functions, and timers that are joined at the end."""
    seat, timers = SeatPrograms(), list[threading.Timer]()
    with seat.running(job := uuid4()), sandbox.open(PROGRAM, policy=policy) as session:
        seat_call = lambda function, *arguments: session.call(function, *arguments).value  # noqa: E731
        timers += [threading.Timer(0.1, seat.stop, (job,)), threading.Timer(0.1 + stopped, seat.go_on, (job,))]
        yield seat, seat_call, timers
    for timer in timers:
        timer.join()


def test_a_stopped_program_loses_none_of_its_time(sandbox: Sandbox) -> None:
    with seat_with_program(sandbox) as (seat, call, timers):
        began, seat_began = time.monotonic(), seat.clock_without_stops()
        for timer in timers:
            timer.start()
        assert call("attendre", STOPPED_SECONDS) == STOPPED_SECONDS
        assert time.monotonic() - began >= STOPPED_SECONDS
        assert seat.clock_without_stops() - seat_began < time.monotonic() - began - 0.9 * STOPPED_SECONDS


@pytest.mark.parametrize("function", ["boucler", "sourde", "tricher"])
def test_a_stopped_program_gains_no_time_either(sandbox: Sandbox, function: str) -> None:
    with seat_with_program(sandbox, BRIEF, 0.5) as (seat, call, timers):
        began, real_began = seat.clock_without_stops(), time.monotonic()
        for timer in timers:
            timer.start()
        with pytest.raises(ProgramFault) as caught:
            call(function)
        assert caught.value.kind is FaultKind.TIMEOUT
        assert seat.clock_without_stops() - began < time.monotonic() - real_began - 0.4


def test_the_line_at_which_time_ran_out_is_known_after_a_stop(sandbox: Sandbox) -> None:
    with seat_with_program(sandbox, BRIEF, 0.5) as (_seat, call, timers):
        for timer in timers:
            timer.start()
        with pytest.raises(ProgramFault) as caught:
            call("attendre", 5.0)
        assert caught.value.line == 5


def test_a_program_that_begins_in_a_stopped_seat_is_stopped(sandbox: Sandbox) -> None:
    """It may answer calls until its template has read the order; then none, until it may go on."""
    seat = SeatPrograms()
    with seat.running(job := uuid4()):
        seat.stop(job)
        answers, goes_on = list[object](), threading.Event()

        def go_on_once_it_stands() -> None:
            seen = -1
            while seen < len(answers):
                seen = len(answers)
                time.sleep(0.2)
            goes_on.set()
            seat.go_on(job)

        watcher = threading.Thread(target=go_on_once_it_stands)
        watcher.start()
        with sandbox.open(PROGRAM) as session:
            while not goes_on.is_set() and len(answers) < MANY_CALLS:
                answers.append(session.call("attendre", 0.0).value)
            assert len(answers) < MANY_CALLS, "it was never stopped"
            answers.append(session.call("attendre", 0.0).value)
        watcher.join()
        assert set(answers) == {0.0}


def test_orders_for_another_job_are_not_obeyed(sandbox: Sandbox) -> None:
    seat = SeatPrograms()
    with seat.running(uuid4()), sandbox.open(PROGRAM) as session:
        for order in (seat.stop, seat.abandon):
            order(uuid4())
        assert session.call("attendre", 0.0).value == 0.0


@pytest.mark.parametrize("stopped", [False, True])
def test_an_abandoned_program_is_no_fault_of_anybody(sandbox: Sandbox, stopped: bool) -> None:
    seat = SeatPrograms()
    with seat.running(job := uuid4()), sandbox.open(PROGRAM) as session:
        if stopped:
            seat.stop(job)
        threading.Timer(0.1, seat.abandon, (job,)).start()
        with pytest.raises(Abandoned):
            session.call("boucler")
    with seat.running(job := uuid4()):
        seat.abandon(job)
        with pytest.raises(Abandoned):
            sandbox.open(PROGRAM)
    with sandbox.open(PROGRAM) as session:
        assert session.call("attendre", 0.0).value == 0.0


def test_a_sandbox_that_closes_ends_stopped_programs(sandbox: Sandbox) -> None:
    seat = SeatPrograms()
    with Sandbox({}, POLICY) as closing, seat.running(job := uuid4()), closing.open(PROGRAM) as session:
        threading.Timer(0.1, seat.stop, (job,)).start()
        threading.Timer(0.2, closing.close).start()
        with pytest.raises((ProgramFault, SandboxFault)):
            session.call("boucler")
