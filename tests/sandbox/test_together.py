"""Questions that travel together, some of them with the file: answered as if each had been asked in its turn."""

from __future__ import annotations

import socket
import time
from collections.abc import Callable, Iterator

import numpy as np
import pytest

from server.sandbox import CallBatch, FaultKind, ProgramFault, Reply, Sandbox, Value
from server.sandbox.answer_shape import AnswerShape
from server.sandbox.child import codec, frames
from server.sandbox.child.codec import (
    UnsendableValue,
    ValueLimits,
    ValueTooBig,
    encode,
    encode_columns,
    encode_returned,
)
from server.sandbox.child.frames import pack_frame
from server.sandbox.session import AnswerBlock
from server.sandbox.values import split_rows
from server.sandbox.wire import DeadlineExceeded, Wire

from .limits import FAR

COUNTING = (
    b"n = 0\ndef f(x):\n    global n\n    n += 1\n    return n, 6 / x\ndef g(x, y):\n    x += y\n    return None\n"
)
LIMITS = ValueLimits(1 << 16, 8, 1000)


def told(number: int, answer: Reply | ProgramFault) -> tuple[int, object]:
    if isinstance(answer, ProgramFault):
        return number, answer.exception or str(answer.kind)
    return number, answer.value if answer.arguments is None else [one and one.tolist() for one in answer.arguments]  # type: ignore[union-attr]


def all_told(blocks: Iterator[AnswerBlock]) -> list[tuple[int, object]]:
    return [told(number, answer) for number, answers in blocks for answer in answers]


ASKED = [
    CallBatch("f", [(1,), (0,), (3,)]),
    CallBatch("absente", [(1,), (2,)]),
    CallBatch("f", [(0,), (0,), (1,)], max_faults=2),
    CallBatch("f", []),
    CallBatch("g", [(np.ones(1), 0.5), (np.ones(1), 0.25)], return_arguments=True),
    CallBatch("f", [(2,)]),
]
ANSWERED = [
    *((0, (1, 6.0)), (0, "ZeroDivisionError"), (0, (3, 2.0))),
    (1, "missing_function"),
    *((2, "ZeroDivisionError"), (2, "ZeroDivisionError")),
    *((4, [[1.5], 0.5]), (4, [[1.25], 0.25, None])),
    (5, (6, 3.0)),
]  # fmt: skip


def test_what_is_asked_with_the_file_is_answered_as_what_is_asked_later(sandbox: Sandbox) -> None:
    asked = [one for one in ASKED if one.function != "g"]
    kept = [(asked.index(ASKED[number]), answer) for number, answer in ANSWERED if ASKED[number].function != "g"]
    with sandbox.open(COUNTING, first_calls=asked) as session:
        assert all_told(session.first_answers) == kept
    with sandbox.open(COUNTING) as session:
        assert all_told(session.call_batches(asked)) == kept


def test_arguments_come_back_where_they_are_asked_for(sandbox: Sandbox) -> None:
    with sandbox.open(COUNTING, first_calls=ASKED[4:5]) as session:
        answers = [answer for _, answers in session.first_answers for answer in answers]
    assert [answer.arguments[0].tolist() for answer in answers if isinstance(answer, Reply) and answer.arguments] == [  # type: ignore[union-attr]
        [1.5],
        [1.25],
    ]


def test_a_program_that_dies_leaves_what_it_has_not_come_to_unanswered(sandbox: Sandbox) -> None:
    source = b"import os\ndef f(x):\n    return x if x < 2 else os._exit(0)\n"
    with sandbox.open(
        source, first_calls=[CallBatch("f", [(0,), (1,)]), CallBatch("f", [(1,), (2,), (1,)]), CallBatch("f", [(0,)])]
    ) as s:
        assert all_told(s.first_answers) == [(0, 0), (0, 1), (1, 1), (1, "runtime_error")]
        assert all_told(s.call_batches([CallBatch("f", [(0,)])])) == [(0, "runtime_error")]


@pytest.mark.parametrize(
    ("source", "kind"), [(b"def f(:", FaultKind.SYNTAX_ERROR), (b"1 / 0", FaultKind.RUNTIME_ERROR)]
)
def test_a_file_that_does_not_load_is_told_and_what_came_with_it_is_dropped(
    sandbox: Sandbox, source: bytes, kind: FaultKind
) -> None:
    with pytest.raises(ProgramFault) as fault:
        sandbox.open(source, first_calls=[CallBatch("f", [(1,)])])
    assert fault.value.kind is kind


def test_much_more_than_the_wire_holds_goes_both_ways(sandbox: Sandbox) -> None:
    asked = [CallBatch("f", [(np.full(20_000, float(k)),)]) for k in range(30)]
    with sandbox.open(b"def f(x):\n    return x + 1\n", policy=FAR, first_calls=asked) as session:
        for number, (answer,) in session.first_answers:
            assert isinstance(answer, Reply)
            assert answer.value[0] == number + 1  # type: ignore[index]
        assert number == 29


def test_questions_that_are_left_are_read_before_another_goes(sandbox: Sandbox) -> None:
    with sandbox.open(COUNTING, first_calls=[CallBatch("f", [(1,), (0,)]), CallBatch("f", [(1,)] * 3)]) as session:
        next(session.first_answers)
        assert session.call("f", 1).value == (6, 6.0)


def test_arguments_that_go_by_columns_are_each_call_s_own_and_of_their_exact_type(sandbox: Sandbox) -> None:
    source = b"""
def f(*args):
    told = [(type(a).__name__, getattr(a, "shape", ()), str(getattr(a, "dtype", ""))) for a in args]
    sound = all(a.flags.owndata and a.flags.writeable and a.flags.c_contiguous for a in args if hasattr(a, "flags"))
    for a in args:
        if hasattr(a, "flags"):
            a *= 0.0
    return told, sound
"""
    turned = np.arange(6.0).reshape(2, 3).T
    rows: list[list[tuple[Value, ...]]] = [
        [(turned, 1.5), (turned, 2.0)],
        [(turned, 1), (turned, 2)],
        [(np.zeros(2), 1.0), (np.zeros(3), 1.0), (np.zeros(3, dtype=np.float32), 1.0)],
        [(np.zeros((0, 2)),), (np.zeros((0, 2)),)],
        [(), ()],
        [(1.0,), (1.0, 2.0), (None,), ([1.0],)],
    ]
    with sandbox.open(source, first_calls=[CallBatch("f", calls) for calls in rows]) as session:
        for number, (calls, answers) in enumerate(zip(rows, _by_number(session.first_answers, len(rows)), strict=True)):
            for args, answer in zip(calls, answers, strict=True):
                assert answer == ([_kind(one) for one in args], True), number


def _kind(value: Value) -> tuple[str, tuple[int, ...], str]:
    shape, dtype = (value.shape, str(value.dtype)) if isinstance(value, np.ndarray) else ((), "")
    return type(value).__name__, shape, dtype


def _by_number(answers: object, length: int) -> list[list[Value]]:
    gathered: list[list[Value]] = [[] for _ in range(length)]
    for number, block in answers:  # type: ignore[attr-defined]
        gathered[number] += [answer.value for answer in block]
    return gathered


#: At its top level, finds the questions that came with it in the memory of the process, and answers them all.
EAGER = """
import os, struct, sys
cadre = sys._getframe()
while "payload" not in cadre.f_locals or "questions" not in cadre.f_locals:
    cadre = cadre.f_back
lot, au = cadre.f_locals["payload"], 0
while au < len(lot):
    longueur, jeton, genre = struct.unpack_from("<IQB", lot, au)
    au += 13 + longueur
    if genre == 3:
        os.write(230, struct.pack("<IQB", 3, jeton, 19) + b"TNN")
def f(x):
    return x
"""


def test_a_file_that_answers_before_it_is_loaded_is_found_out(sandbox: Sandbox) -> None:
    with pytest.raises(ProgramFault) as fault:
        sandbox.open(EAGER.encode(), first_calls=[CallBatch("f", [(1,)])])
    assert fault.value.kind is FaultKind.INVALID_OUTPUT


def test_an_answer_of_the_last_one_s_form_reads_as_the_decoder_does() -> None:
    rng = np.random.default_rng(5)
    values: list[Value] = [1.5, rng.normal(size=3), rng.normal(size=(2, 3)), np.zeros((0, 3)), 3, (1.0, 2.0), None]
    values += [rng.normal(size=3).astype(np.float32), np.array([True, False]), [rng.normal(size=3)]]
    for before in values:
        alike = AnswerShape()
        answer = encode((before, None), LIMITS)
        alike.learn(answer, *codec.decode_counted(answer, LIMITS))
        for value in (*values, np.array([np.nan, np.inf, -0.0]), -0.0):
            for data in _mutants(encode((value, None), LIMITS), rng):
                read = alike.read(data)
                if read is not None:
                    decoded, items = codec.decode_counted(data, LIMITS)
                    assert items == alike.items
                    assert repr(decoded) == repr((read, None))
                    assert not isinstance(read, np.ndarray) or (read.flags.c_contiguous and read.flags.writeable)
    assert alike.read(encode((1.0, (1,)), LIMITS)) is None


@pytest.mark.parametrize("shape", [None, (3,), (2, 3)])
def test_answers_that_are_here_are_taken_in_up_to_the_first_that_is_another(shape: tuple[int, ...] | None) -> None:
    values: list[Value] = [float(k) if shape is None else np.full(shape, float(k)) for k in range(6)]
    answers = [encode((one, None), LIMITS) for one in values]
    sound = [pack_frame(10 + k, frames.VALUE, answer) for k, answer in enumerate(answers)]
    assert _taken_in([*sound, END]) == repr(values[1:])
    for place in range(1, 7):
        strange = [b"", sound[place - 1], END, sound[place % 6][:-1], pack_frame(10 + place, frames.FAULT, answers[0])]
        strange += [
            pack_frame(7, frames.VALUE, b""),
            pack_frame(10 + place, frames.VALUE, encode((np.zeros(4), None), LIMITS)),
        ]
        strange += [pack_frame(10 + place, frames.VALUE, answers[0][:-1] + b"T"), pack_frame(8, frames.DONE, b"")]
        for other in strange[place == 6 :]:
            if other != [*sound, END][place]:
                # The last answer is taken in with what ends the batch, and with nothing else.
                assert _taken_in([*sound[:place], other, *[*sound, END][place + 1 :]]) == repr(
                    values[1 : min(place, 5)]
                )
    assert _taken_in(sound) == repr(values[1:5])


END = pack_frame(7, frames.DONE, b"")


def _taken_in(came: list[bytes]) -> str:
    ours, theirs = socket.socketpair()
    with ours, theirs:
        theirs.sendall(b"".join(came))
        wire, form = Wire(ours), AnswerShape()
        _, answer = wire.receive(10, frozenset({frames.VALUE}), 1 << 16, time.monotonic() + 60)
        form.learn(answer, *codec.decode_counted(answer, LIMITS))
        values = split_rows(wire.receive_same_shape(range(11, 16), frames.VALUE, form, END))
        # What is left is what has not been given.
        assert wire.has_whole_answer is (b"".join(came[1 + len(values) :]) != (END if len(values) == 5 else b""))
        return repr(values)


@pytest.mark.parametrize(
    "columns", [(np.arange(3.0),), (np.arange(12.0).reshape(4, 3)[::2], np.zeros((2, 1, 5)).T), (np.zeros((0, 3)),)]
)
def test_columns_are_encoded_as_all_other_arrays_are(columns: tuple[np.ndarray, ...]) -> None:
    assert encode_columns(columns) == encode(columns, LIMITS)


def test_what_most_answers_are_is_encoded_as_all_others_are() -> None:
    floats = np.arange(6.0)
    values: list[Value] = [1.5, -0.0, np.nan, floats, floats.reshape(2, 3), floats.reshape(2, 3).T, floats[::2]]
    values += [
        floats[:0],
        np.float64(2.5),
        np.array(1.5),
        floats.astype(">f8"),
        floats.astype(np.float32),
        3,
        True,
        None,
        [1.0],
    ]
    values += [np.zeros((1,) * 9), np.ma.masked_array(floats)]
    bounds = [
        LIMITS,
        *(ValueLimits(size, 8, 1000) for size in range(70)),
        ValueLimits(1 << 16, 1, 1000),
        ValueLimits(1 << 16, 8, 2),
    ]
    for value in values:
        for limits in bounds:
            assert _outcome(encode_returned, value, limits) == _outcome(encode, (value, None), limits)


def _outcome(encoded: Callable[[object, ValueLimits], bytes], value: object, limits: ValueLimits) -> object:
    try:
        return encoded(value, limits)
    except (ValueTooBig, UnsendableValue) as error:
        return repr(error)


def _mutants(data: bytes, rng: np.random.Generator) -> list[bytes]:
    made = [data]
    for at in rng.integers(0, len(data), 12):
        made.append(data[:at] + bytes([int(rng.integers(256))]) + data[at + 1 :])
    return made


@pytest.mark.parametrize("length", [21, 22, 23])
def test_an_answer_is_waited_for_as_far_as_it_is_of_the_form_of_the_last(length: int) -> None:
    """Of another length only the beginning is: what must be read of it, if anything, is another's business."""
    answer = encode((1.0, None), LIMITS)
    ours, theirs = socket.socketpair()
    with ours, theirs:
        wire, form = Wire(ours), AnswerShape()
        form.learn(answer, *codec.decode_counted(answer, LIMITS))
        theirs.sendall(frames.HEADER.pack(form.answer_bytes + length - 22, 10, frames.VALUE))
        if length == 22:
            with pytest.raises(DeadlineExceeded):
                wire.wait_for_answer(form, time.monotonic() + 0.05)
            theirs.sendall(answer)
        wire.wait_for_answer(form, time.monotonic() + 60)
        assert wire.has_whole_answer is (length == 22)
