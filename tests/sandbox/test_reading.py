"""The trusted reading path on hostile bytes: the properties of `tests.fuzz`, on inputs that take a few seconds."""

from __future__ import annotations

import random
import struct
import tracemalloc
from typing import Any

import numpy as np
import pytest

from server.sandbox import FaultKind, Policy, diagnosis
from server.sandbox.child import frames
from server.sandbox.child.codec import ValueLimits, decode, encode
from tests.fuzz import reading, structured

LIMITS = ValueLimits(1 << 16, 8, 1000)
FAULT: dict[str, Any] = {
    "kind": "runtime_error",
    "exception": "ValueError",
    "text": "non",
    "line": 3,
    "frames": ((3, "f", "raise ValueError"),),
    "detail": "",
}


def mutated(source: random.Random) -> bytes:
    """One of the seeds with a few bytes changed, cut, doubled or put elsewhere."""
    data = bytearray(source.choice(reading.SEEDS))
    for _ in range(source.randint(1, 4)):
        at, length = source.randrange(len(data) + 1), source.randint(1, 8)
        match source.randrange(4):
            case 0:
                data[at : at + 1] = bytes([source.choice((0, 1, 255, source.randrange(256)))])
            case 1:
                del data[at : at + length]
            case 2:
                data[at:at] = data[: length * 4]
            case _:
                data[at:at] = struct.pack("<I", source.choice((0, 1, 2**31, 2**32 - 1)))
    return bytes(data)


def test_mutated_bytes_give_exact_types_or_malformed_and_little_memory() -> None:
    source = random.Random(20)
    tracemalloc.start()
    try:
        values = sum(reading.decode_soundly(mutated(source)) for _ in range(2_000))
    finally:
        tracemalloc.stop()
    assert 0 < values < 2_000


#: Values in a crowd: what they take together hides what reading takes at the least.
CROWD = 4_000


@pytest.mark.parametrize(
    "smallest", [b"N", b"t\0\0\0\0", b"l\0\0\0\0", b"d\0\0\0\0", b"s\0\0\0\0", b"a\1\0\0", b"a\1\1" + bytes(4)]
)
def test_a_crowd_of_the_smallest_values_stays_within_the_bound_of_memory(smallest: bytes) -> None:
    tracemalloc.start()
    try:
        assert reading.decode_soundly(b"l" + struct.pack("<I", CROWD) + smallest * CROWD)
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize(("name", "test"), structured.tests(80).items(), ids=lambda value: str(value)[:8])
def test_structured_bytes_break_no_property(name: str, test: Any) -> None:
    test()


@pytest.mark.parametrize(
    "change",
    [
        {"kind": []},
        {"kind": np.zeros(2)},
        {"kind": "internal_error"},
        {"kind": "missing_function"},
        {"text": None},
        {"text": "x" * 601},
        {"detail": "x" * 601},
        {"exception": "E" * 81},
        {"frames": [(3, "f", "x")]},
        {"frames": ((3, "f", "x"),) * 9},
        {"frames": ((3, "f"),)},
        {"frames": ((3, "f", "x" * 201),)},
        {"frames": ((3, 4, "x"),)},
        {"autre": 1},
    ],
    ids="-".join,
)
def test_a_fault_in_another_form_than_a_childs_is_a_forgery(change: dict[str, Any]) -> None:
    assert reading.tell_soundly(encode(FAULT, LIMITS)) == "runtime_error"
    assert reading.tell_soundly(encode(FAULT | change, LIMITS)) == ""
    answer = reading.framed(encode(FAULT | change, LIMITS), frames.FAULT)
    assert reading.converse_soundly(answer) == "invalid_output"


@pytest.mark.parametrize("line", [0, -3, 10**6, 10**30, None, True, 1.0, "3", (3,)], ids=repr)
def test_a_bad_line_is_no_line_and_no_forgery(line: Any) -> None:
    """A frame that has just been entered has none yet: a time-out there was told as cheating."""
    fault = FAULT | {"kind": "timeout", "line": line, "frames": ((3, "f", "g()"), (line, "g", ""))}
    found = diagnosis.parse_fault(decode(encode(fault, LIMITS), LIMITS), Policy())
    assert found is not None
    assert (found.kind, found.line) == (FaultKind.TIMEOUT, None)
    assert [frame.function for frame in found.frames] == ["f"]


@pytest.mark.parametrize(
    "names", [["f"], ("f", 1), ("x" * 121,), ("f",) * 1001, "f"], ids=lambda names: type(names).__name__
)
def test_names_in_another_form_than_a_childs_are_a_forgery(names: Any) -> None:
    answer = reading.framed(encode((names, ()), reading.LIMITS))
    assert reading.converse_soundly(answer, loading=True) == "invalid_output"


@pytest.mark.parametrize(
    ("status", "kind"), [(0, "runtime_error"), (31, "forbidden_operation"), (24, "timeout"), (9, "memory_limit")]
)
def test_a_half_frame_is_told_by_the_way_the_child_died(status: int, kind: str) -> None:
    whole = reading.framed(encode((1, None), reading.LIMITS))
    for length in range(len(whole)):
        assert reading.converse_soundly(whole[:length], status=status) == kind


def test_an_answer_and_the_end_of_its_batch_leave_the_session_whole_until_the_child_leaves() -> None:
    answer = reading.framed(encode((1, None), reading.LIMITS))
    assert reading.converse_soundly(answer, status=9) == "memory_limit"
    assert reading.converse_soundly(answer + answer, status=9) == "invalid_output"
    assert reading.converse_soundly(reading.DONE, status=9) == "invalid_output"
