"""Many calls in one question: answers one by one, each with its own fault, and the right call to blame."""

from __future__ import annotations

import time
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from server.sandbox import FaultKind, Policy, ProgramFault, Reply, Sandbox, SandboxFault, Session, Value

from .limits import FAR, only


def answers(session: Session, calls: list[tuple[Value, ...]], *, faults: int | None = None) -> list[object]:
    """Of each call of `f`: its value, or the exception or the kind of its fault."""
    return [
        given.value if isinstance(given, Reply) else given.exception or str(given.kind)
        for given in session.call_many("f", calls, faults=faults)
    ]


def test_many_calls_answer_in_order_each_with_its_own_fault(sandbox: Sandbox) -> None:
    source = b"n = 0\ndef f(x):\n    global n\n    n += 1\n    return n, 6 / x\n"
    with sandbox.open(source) as session:
        given = answers(session, [(1,), (0,), (3,), ("a",), (2,)])
        assert given == [(1, 6.0), "ZeroDivisionError", (3, 2.0), "TypeError", (5, 3.0)]
        assert session.call("f", 6).value == (6, 1.0)
        assert answers(session, []) == []


def test_calls_without_end_go_by_batches_that_do_not_block_and_are_drawn_as_they_go(sandbox: Sandbox) -> None:
    """Both ways carry far more than the wire holds at once."""
    drawn = 0

    def calls() -> Iterator[tuple[Value, ...]]:
        nonlocal drawn
        for k in range(40):
            drawn += 1
            yield (np.full(20_000, float(k)), k)

    with sandbox.open(b"def f(x, k):\n    return x + k\n") as session:
        for k, answer in enumerate(session.call_many("f", calls())):
            assert isinstance(answer, Reply)
            assert answer.value[0] == 2.0 * k  # type: ignore[index]
            assert drawn - k <= 4
        assert answers(session, [(k, 1) for k in range(1000)]) == list(range(1, 1001))


def test_a_program_stops_by_itself_after_as_many_faults_as_are_asked_for(sandbox: Sandbox) -> None:
    source = b"n = 0\ndef f(x):\n    global n\n    n += 1\n    return n / x\n"
    with sandbox.open(source) as session:
        given = answers(session, [(1,), (0,), (0,), (1,), (0,)], faults=2)
        assert given == [1.0, "ZeroDivisionError", "ZeroDivisionError"]
        assert session.call("f", 1).value == 4.0


def test_faults_are_counted_over_all_the_batches(sandbox: Sandbox) -> None:
    with sandbox.open(b"n = 0\ndef f(x):\n    global n\n    n += 1\n    return n / x\n") as session:
        calls: list[tuple[Value, ...]] = [(0.0 if k in (100, 200, 300) else 1.0,) for k in range(500)]
        assert len(answers(session, calls, faults=3)) == 301
        assert session.call("f", 1).value == 302.0


@pytest.mark.parametrize(
    ("line", "kind", "policy"),
    [
        ("os._exit(3)", FaultKind.RUNTIME_ERROR, FAR),
        ("ctypes.string_at(0)", FaultKind.RUNTIME_ERROR, FAR),
        ("while True: pass", FaultKind.TIMEOUT, only(cpu_seconds=0.3)),
        ("time.sleep(3600)", FaultKind.TIMEOUT, only(wall_seconds=1.0)),
        ("os.close(230); time.sleep(3600)", FaultKind.INVALID_OUTPUT, FAR),
    ],
)
def test_the_call_during_which_a_program_ends_is_the_one_to_blame(
    sandbox: Sandbox, line: str, kind: FaultKind, policy: Policy
) -> None:
    source = f"import ctypes, os, time\ndef f(x):\n    if x == 5:\n        {line}\n    return x\n".encode()
    with sandbox.open(source, policy=policy) as session:
        given = list(session.call_many("f", [(k,) for k in range(9)]))
        assert [answer.value for answer in given[:-1] if isinstance(answer, Reply)] == [0, 1, 2, 3, 4]
        assert isinstance(given[5], ProgramFault)
        assert (given[5].kind, given[5].fatal) == (kind, True)
        assert list(session.call_many("f", [(1,), (2,)])) == [given[5]]


def test_a_program_that_stops_the_timer_is_late_all_the_same(sandbox: Sandbox) -> None:
    """One timer serves a batch: what stands behind it is the end from outside."""
    source = b"""
import signal, time
def f(x):
    signal.setitimer(signal.ITIMER_REAL, 0)
    time.sleep(3600 * (x == 5))
"""
    with sandbox.open(source, policy=only(wall_seconds=1.0)) as session:
        given = list(session.call_many("f", [(k,) for k in range(9)]))
    assert all(isinstance(answer, Reply) for answer in given[:5])
    assert isinstance(given[5], ProgramFault)
    assert (given[5].kind, given[5].fatal, len(given)) == (FaultKind.TIMEOUT, True, 6)


def floats(value: Value) -> tuple[float, ...]:
    assert isinstance(value, tuple)
    return tuple(number for number in value if isinstance(number, float))


def test_the_time_of_a_batch_is_what_is_left_of_the_session(sandbox: Sandbox) -> None:
    """The program's timer says what is left of its time: a call finds less than the one before did."""
    source = b"""
import signal, time
def f(x):
    before = signal.getitimer(signal.ITIMER_REAL)[0]
    time.sleep(x)
    return before, signal.getitimer(signal.ITIMER_REAL)[0]
"""
    with sandbox.open(source) as session:
        given = [session.call("f", 0.05), *session.call_many("f", [(0.05,), (0.0,), (0.05,)]), session.call("f", 0.0)]
        left = [moment for answer in given if isinstance(answer, Reply) for moment in floats(answer.value)]
    starts, ends = left[::2], left[1::2]
    assert sandbox.policy.wall_seconds > starts[0]
    assert len(starts) == len(ends) == 5
    assert all(start >= end for start, end in zip(starts, ends, strict=True))
    # the message of a call may wait, its time not running yet: what the call before has used is gone all the same
    used = [before - after for before, after in pairwise(starts)]
    assert all(seconds >= slept for seconds, slept in zip(used, (0.05, 0.05, 0.0, 0.05), strict=True))


WAITS = b"""
import os, signal, time
import numpy as np
writing, write, seen = 0.0, os.write, []

def timed_write(*arguments):
    global writing
    start = time.monotonic()
    count = write(*arguments)
    writing += time.monotonic() - start
    return count

os.write = timed_write

def f(x):
    earliest = time.monotonic()
    seen.append((earliest, signal.getitimer(signal.ITIMER_REAL)[0], writing, time.monotonic()))
    return np.full(50_000, x)

def told():
    return tuple(seen)
"""


def test_time_that_the_asker_takes_between_two_answers_is_not_the_programs(sandbox: Sandbox) -> None:
    """Answers fill the wire while nobody reads them: the program waits, and its time stands still."""
    with sandbox.open(WAITS) as session:
        given = []
        for answer in session.call_many("f", [(float(k),) for k in range(4)]):
            time.sleep(0.1)
            assert isinstance(answer, Reply)
            given.append(answer.value[-1])  # type: ignore[index]
        told = session.call("told").value
    assert given == [0.0, 1.0, 2.0, 3.0]
    assert isinstance(told, tuple)
    moments = [floats(moment) for moment in told]
    assert len(moments) == 4
    for (earliest, left, written, _), (_, left_later, written_later, latest) in pairwise(moments):
        assert left - left_later <= (latest - earliest) - (written_later - written) + 0.001


def test_an_iterator_that_is_left_lets_the_program_go_on(sandbox: Sandbox) -> None:
    source = b"n = 0\ndef f(x):\n    global n\n    n += 1\n    return n\n"
    with sandbox.open(source) as session:
        left = session.call_many("f", [(k,) for k in range(10)])
        next(left)
        assert session.call("f", 0).value == 11
        with pytest.raises(SandboxFault):
            next(left)
        next(session.call_many("f", [(k,) for k in range(10)]))
    with pytest.raises(SandboxFault):
        session.call_many("f", [(1,)])


def test_a_program_that_ends_after_its_iterator_was_left_is_dead_to_the_next_call(sandbox: Sandbox) -> None:
    with sandbox.open(b"import os\ndef f(x):\n    return x if x < 3 else os._exit(0)\n") as session:
        left = session.call_many("f", [(k,) for k in range(5)])
        next(left)
        assert answers(session, [(1,)]) == ["runtime_error"]
        assert [str(given.kind) for given in left if isinstance(given, ProgramFault)] == ["runtime_error"]


def test_each_call_finds_arguments_of_its_own(sandbox: Sandbox) -> None:
    source = b"def f(x):\n    x += 1\n    return x\n"
    same = np.zeros(2)
    with sandbox.open(source) as session:
        given = list(session.call_many("f", [(same,), (same,), (same,)], return_arguments=True))
        for number, answer in enumerate(given):
            assert isinstance(answer, Reply)
            assert answer.arguments is not None
            values = [array.tolist() for array in (answer.value, *answer.arguments)]  # type: ignore[union-attr]
            assert values == [[1.0, 1.0]] * (3 if number else 2)  # the value before comes after the arguments
    assert same.tolist() == [0.0, 0.0]


def test_a_value_comes_back_as_the_next_call_leaves_it(sandbox: Sandbox) -> None:
    source = b"kept = [0]\ndef f(x):\n    if x:\n        kept[0] = x\n        return kept\n    raise ValueError\n"
    with sandbox.open(source) as session:
        given = list(session.call_many("f", [(1,), (2,), (0,), (3,)], return_arguments=True))
        assert [answer.arguments for answer in given if isinstance(answer, Reply)] == [(1,), (2, [2]), (3, None)]


def test_a_missing_function_answers_once_for_all_its_calls(sandbox: Sandbox) -> None:
    with sandbox.open(b"def g(x):\n    return x\n") as session:
        assert answers(session, [(1,), (2,)]) == ["missing_function"]
        assert session.call("g", 1).value == 1


FORGER = """
import os, struct, sys

def cadre_du_lot():
    cadre = sys._getframe()
    while "tokens" not in cadre.f_locals:
        cadre = cadre.f_back
    return cadre

def ecrit(jeton, genre, contenu=b""):
    os.write(230, struct.pack("<IQB", len(contenu), jeton, genre) + contenu)

VINGT = b"t\\x02\\0\\0\\0i\\x14\\0\\0\\0\\0\\0\\0\\0N"

def f(x):
    if x == 1:
        lot = cadre_du_lot()
        courant, fin = lot.f_locals["self"]._token, lot.f_locals["end"]
        suivants = lot.f_locals["tokens"][lot.f_locals["number"] + 1 :]
        if ATTAQUE == "avance":
            for jeton in suivants:
                ecrit(jeton, 19, VINGT)
        elif ATTAQUE == "double":
            ecrit(courant, 19, VINGT)
        elif ATTAQUE == "saute":
            ecrit(suivants[0], 19, VINGT)
        elif ATTAQUE == "fin":
            ecrit(fin, 21)
        elif ATTAQUE == "tout":
            for jeton in (courant, *suivants):
                ecrit(jeton, 19, VINGT)
            ecrit(fin, 21)
        elif ATTAQUE == "de trop":
            for jeton in (courant, *suivants, fin):
                ecrit(jeton, 19, VINGT)
    return x
"""


@pytest.mark.parametrize(("attack", "sound"), [("avance", 1), ("double", 2), ("saute", 1), ("fin", 1), ("de trop", 4)])
def test_answers_out_of_their_turn_are_the_failure_of_the_submission(sandbox: Sandbox, attack: str, sound: int) -> None:
    """Tokens of the questions ahead can be found by who looks for them; the order cannot be cheated all the same."""
    with sandbox.open(f"ATTAQUE = {attack!r}\n{FORGER}".encode()) as session:
        given = answers(session, [(k,) for k in range(5)])
        assert given[sound:] == ["invalid_output"]
        assert answers(session, [(0,)]) == ["invalid_output"]


def test_a_program_that_answers_for_the_machinery_is_found_out_at_the_next_question(sandbox: Sandbox) -> None:
    """It only lied about its own values, which it could have returned."""
    with sandbox.open(f"ATTAQUE = 'tout'\n{FORGER}".encode()) as session:
        assert answers(session, [(k,) for k in range(4)]) == [0, 20, 20, 20]
        assert answers(session, [(0,)]) == ["invalid_output"]
