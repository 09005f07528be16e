"""The pipes between a program and the course's functions: what a program may do there harms itself alone."""

from __future__ import annotations

import os
import threading
from collections.abc import Iterator
from types import ModuleType
from uuid import uuid4

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from server.sandbox import FaultKind, Kit, LibraryFile, Policy, ProgramFault, Sandbox
from server.sandbox.child import codec, course_calls, course_channel, small_values
from server.sandbox.child.frames import ASK_LIMITS
from server.sandbox.seat import SeatPrograms

COURSE = b"""
import time
def double(x):
    return x + x
def dort(secondes):
    time.sleep(secondes)
    return secondes
"""
LIBRARY = (LibraryFile("cours", ("double", "dort"), COURSE, sealed=True),)
KIT = Kit("trousse", {"seed": 4}, library=LIBRARY)
HEAD = """
import os, signal, struct, sys, threading, time
from mes_fonctions import double, dort
def frame(payload):
    return struct.pack("<I", len(payload)) + payload
def ask_trusted_side():
    level = sys._getframe()
    while "tokens" not in level.f_locals:
        level = level.f_back
    os.write(230, struct.pack("<IQB", 0, level.f_locals["self"]._token, 32))
"""


@pytest.fixture(scope="module")
def sandbox() -> Iterator[Sandbox]:
    with Sandbox({"trousse": "def configurer(seed=None):\n    return {}\n"}) as sandbox:
        yield sandbox


def run(sandbox: Sandbox, body: str, policy: Policy | None = None, calls: int = 1) -> object:
    source = HEAD + "def f():\n" + "".join(f"    {line}\n" for line in body.splitlines())
    with sandbox.open(source.encode(), kit=KIT, policy=policy) as session:
        return [session.call("f").value for _ in range(calls)][-1]


@pytest.mark.parametrize(
    "body",
    [
        "os.write(228, b'abc')\nreturn 7",
        "double(1)\nos.write(228, frame(b'N' * 9)[:8])\nreturn 7",
        "double(1)\nos.close(228)\nos.close(227)\nreturn 7",
        "double(1)\nos.write(228, struct.pack('<I', 1 << 30) + b'x')\nreturn 7",
        "double(1)\nfor _ in range(500): os.write(228, frame(b''))\nreturn 7",
        "double(1)\nos.write(228, frame(b'l' + struct.pack('<I', 60000) + b'N' * 60000))\nreturn 7",
    ],
)
def test_nonsense_on_the_channel_changes_no_answer(sandbox: Sandbox, body: str) -> None:
    assert run(sandbox, body) == 7


@pytest.mark.parametrize(
    "body",
    [
        "double(1)\nos.close(228)\nreturn double(2)",
        "double(1)\nos.close(227)\nreturn double(2)",
        "double(1)\nos.write(228, struct.pack('<I', 1 << 30))\nreturn double(2)",
        "double(1)\nask_trusted_side()\ntime.sleep(60)",
        "ask_trusted_side()\nask_trusted_side()\ntime.sleep(60)",
    ],
)
def test_a_program_that_breaks_the_channel_has_itself_to_blame(sandbox: Sandbox, body: str) -> None:
    """Nothing that it does there is an error of ours, for which it would be graded again."""
    with pytest.raises(ProgramFault) as caught:
        run(sandbox, f"try:\n    {body.replace(chr(10), chr(10) + '    ')}\nexcept BaseException:\n    return 1")
    assert caught.value.kind is FaultKind.INVALID_OUTPUT


@pytest.mark.parametrize(
    "body",
    [
        "double(1)\nwhile True: os.write(228, frame(b'N'))",
        "double(1)\nsignal.setitimer(signal.ITIMER_REAL, 0)\ntime.sleep(60)",
        "double(1)\nos.read(227, 1)",
    ],
)
def test_a_program_that_waits_there_runs_out_of_time(sandbox: Sandbox, body: str) -> None:
    with pytest.raises(ProgramFault) as caught:
        run(sandbox, body, Policy(wall_seconds=0.2))
    assert caught.value.kind is FaultKind.TIMEOUT


def test_time_spent_in_the_course_is_not_a_programs_own_in_later_calls_either(sandbox: Sandbox) -> None:
    """Ten calls of 0.12 s there are more than the program has, which needs little itself."""
    assert run(sandbox, "return dort(0.12)", Policy(wall_seconds=1.0), calls=10) == 0.12


def test_the_course_has_as_much_time_as_the_program_and_no_more(sandbox: Sandbox) -> None:
    with pytest.raises(ProgramFault) as caught:
        run(sandbox, "return dort(60)", Policy(wall_seconds=0.2))
    assert (caught.value.kind, caught.value.frames[-1].source) == (FaultKind.TIMEOUT, "return dort(60)")


def test_a_program_that_is_stopped_while_it_calls_the_course_loses_no_time(sandbox: Sandbox) -> None:
    """It is stopped for longer than it and the course have time, in a call, and calls again after that."""
    seat, job = SeatPrograms(), uuid4()
    source = HEAD + "def f(secondes):\n    return dort(secondes)\n"
    with seat.running(job), sandbox.open(source.encode(), kit=KIT, policy=Policy(wall_seconds=0.4)) as session:
        assert session.call("f", 0.0).value == 0.0
        timers = threading.Timer(0.1, seat.stop, (job,)), threading.Timer(1.1, seat.go_on, (job,))
        for timer in timers:
            timer.start()
        assert [session.call("f", seconds).value for seconds in (0.3, 0.1)] == [0.3, 0.1]
        for timer in timers:
            timer.join()


def test_threads_get_each_their_own_reply(sandbox: Sandbox) -> None:
    body = """
found = []
def check(k):
    found.append(all(double(k) == 2 * k for _ in range(50)))
threads = [threading.Thread(target=check, args=(k,)) for k in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
return found
"""
    assert run(sandbox, body.strip(), Policy(threads=8)) == [True] * 4


def test_a_call_that_a_program_cuts_short_answers_no_other(sandbox: Sandbox) -> None:
    body = """
def stop(*_):
    raise KeyError("assez")
signal.signal(signal.SIGALRM, stop)
signal.setitimer(signal.ITIMER_REAL, 0.05)
try:
    dort(0.3)
except KeyError:
    pass
return double(4)
"""
    with pytest.raises(ProgramFault) as caught:
        run(sandbox, body.strip())
    assert (caught.value.kind, caught.value.exception) == (FaultKind.RUNTIME_ERROR, "RuntimeError")


floats = st.floats(width=64)
plain = st.recursive(
    st.none()
    | st.booleans()
    | st.integers(-(2**70), 2**70)
    | floats
    | floats.map(np.float64)
    | st.complex_numbers()
    | st.text(max_size=5)
    | arrays.arrays(
        st.sampled_from(["<f8", ">f8", "<f4", "<i8", "bool"]), arrays.array_shapes(min_dims=0, max_dims=3, min_side=0)
    ),
    lambda inside: (
        st.lists(inside, max_size=4)
        | st.lists(inside, max_size=4).map(tuple)
        | st.dictionaries(st.text(max_size=3) | st.integers(), inside, max_size=3)
    ),
    max_leaves=12,
)


def outcome(function: object, *arguments: object) -> object:
    """Return the value, or the error, in a form that compares."""
    try:
        value = function(*arguments)  # type: ignore[operator]
    except (codec.MalformedValue, codec.UnsendableValue, codec.ValueTooBig) as error:
        return type(error), error.args
    return value if isinstance(value, bytes) else described(value)


def described(value: object) -> object:
    if isinstance(value, np.ndarray):
        sound = value.flags.writeable and value.flags.owndata and value.flags.c_contiguous
        return type(value), value.dtype.str, value.shape, value.tobytes(), sound
    if isinstance(value, (list, tuple)):
        return type(value), [described(item) for item in value]
    if isinstance(value, dict):
        return {key: described(item) for key, item in value.items()}
    return type(value), repr(value)


@given(plain)
def test_small_values_are_encoded_as_all_others(value: object) -> None:
    assert outcome(small_values.encode, value, ASK_LIMITS) == outcome(codec.encode, value, ASK_LIMITS)


@given(plain, st.data())
def test_small_values_are_decoded_as_all_others_whole_or_damaged(value: object, data: st.DataObject) -> None:
    try:
        encoded = bytearray(codec.encode(value, ASK_LIMITS))
    except codec.UnsendableValue:
        return
    for _ in range(data.draw(st.integers(0, 3))):
        encoded[data.draw(st.integers(0, len(encoded) - 1))] = data.draw(st.integers(0, 255))
    damaged = bytes(encoded[: data.draw(st.integers(0, len(encoded)))] if data.draw(st.booleans()) else encoded)
    assert outcome(small_values.decode, damaged, ASK_LIMITS) == outcome(codec.decode, damaged, ASK_LIMITS)


FUNCTIONS = ModuleType("fonctions")
vars(FUNCTIONS)["double"] = lambda x: x + x


def valid_call(argument: object) -> bytes:
    return codec.encode(("double", (argument,), {}), ASK_LIMITS)


@given(st.binary(max_size=80) | st.tuples(st.integers(0, 40), st.binary(max_size=4)))
def test_crafted_calls_get_a_reply_that_is_a_value_or_an_exception(crafted: bytes | tuple[int, bytes]) -> None:
    question = crafted
    if isinstance(crafted, tuple):
        whole, (at, change) = valid_call(1.5), crafted
        question = whole[:at] + change + whole[at + len(change) :]
    assert isinstance(question, bytes)
    reply = codec.decode(course_calls.answer_call(question, FUNCTIONS, {"double"}), ASK_LIMITS)
    assert isinstance(reply, tuple)
    assert reply[0] in (course_calls.VALUE, course_calls.SCALAR, course_calls.RAISED)


@given(st.lists(st.binary(max_size=30), max_size=6), st.integers(1, 40))
def test_frames_come_out_whole_however_they_arrive(payloads: list[bytes], piece: int) -> None:
    reader, writer = os.pipe()
    with os.fdopen(reader, "rb", buffering=0) as near, os.fdopen(writer, "wb", buffering=0) as far:
        stream = b"".join(len(payload).to_bytes(4, "little") + payload for payload in payloads)
        pieces = [stream[k : k + piece] for k in range(0, len(stream), piece)]
        thread = threading.Thread(target=far.writelines, args=(pieces,))
        thread.start()
        frames = course_channel.FrameReader(near.fileno())
        assert [frames.read() for _ in payloads] == payloads
        thread.join()
        far.close()
        with pytest.raises(EOFError):
            frames.read()
