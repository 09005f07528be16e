"""What a followed program tells is read strictly: what a tracer makes comes out, anything else is refused."""

from __future__ import annotations

import random
from contextlib import suppress
from typing import Any

import numpy as np
import pytest

from server.sandbox import Value
from server.sandbox.child import codec
from server.sandbox.child.frames import STEP_LIMITS
from server.sandbox.child.value_descriptions import ValueDescriber
from server.steps import values
from server.steps.run import _read_returned_value
from server.steps.schemas import TraceOut
from server.steps.trace_reader import MAX_TRACE_BYTES, TraceReader
from server.steps.values import MalformedTrace
from tests.support.tables import folded

SHOWN = {
    "none": [None],
    "bool": [True, False],
    "number": [3, -(10**200), 10**5000, 0.1, float("nan"), -0.0, 1j, np.float64(2), np.int8(-3), np.bool_(True)],
    "text": ["", "é" * 1000, "\u202eabc\x1b[2J"],
    "sequence": [[], [1, [2, [3]]], (1,), {1}, frozenset("a"), range(10), range(10**100)],
    "mapping": [{}, {"a": 1, 2: [3], (1, 2): None}],
    "array": [np.eye(2), np.zeros((0, 3)), np.array(["a", None, 1.5], dtype=object), np.zeros(3, dtype="V4")],
    "other": [object(), np, len, values.read_value, MalformedTrace],
}


def arrived(value: object) -> Value:
    """What the trusted side has of a value that a tracer describes."""
    return codec.decode(codec.encode(ValueDescriber().describe(value), STEP_LIMITS), STEP_LIMITS)


@pytest.mark.parametrize("kind", SHOWN)
def test_what_a_tracer_describes_is_read(kind: str) -> None:
    for read in map(values.read_value, map(arrived, SHOWN[kind])):
        assert read.kind == kind
        assert read.model_dump_json().isprintable()


@pytest.mark.parametrize(
    ("value", "written"),
    [
        (np.array([0.1, 1], dtype="f4"), ["0.1", "1.0"]),
        (np.array([1, 255], dtype="u1"), ["1", "255"]),
        (np.array([True]), ["True"]),
        (np.array([1 + 2j, np.inf]), ["(1+2j)", "(inf+0j)"]),
        (np.array([1.5], dtype="g"), ["1.5"]),
        (np.array(["ab", "\x1b"]), ["ab", "␛"]),
        (np.arange(1000), [*map(str, range(400))]),
        (np.arange(6).reshape(2, 3).T, ["0", "3", "1", "4", "2", "5"]),
    ],
)
def test_the_numbers_of_an_array_are_written_as_python_does(value: Any, written: list[str]) -> None:
    assert values.read_value(arrived(value)).values == written  # type: ignore[union-attr]


HOSTILE: list[Any] = [
    *[None, 1, "none", [], (), ("none", 1), ("bool", 1), ("int", True), ("int", 1.0), ("float", 1), ("big", -1)],
    *[("numpy", "<f8", "a" * 300), ("numpy", 8, 1), ("text", "a" * 201, 1), ("text", "a", 1.0)],
    *[("sequence", "html", None, 0, ()), ("sequence", "list", "a", 0, ()), ("sequence", "list", None, 0, [])],
    *[("sequence", "list", None, -1, ()), ("sequence", "list", None, 1, (("none",),) * 1000)],
    *[("mapping", None, 1, ((("none",),),)), ("mapping", None, 1, (1,)), ("mapping", 1.5, 0, ())],
    *[("array", "<f8", None, (2,), (1.0,) * 3), ("array", "<f8", None, (-1,), ()), ("array", "<f8", None, [2], ())],
    *[("array", "<f8", None, (1,) * 100, ()), ("array", "<f8", None, (1000,), (1.0,) * 401)],
    *[("array", "<f8", None, (1,), (None,)), ("array", "<f8", None, (1,), (np.zeros(3),))],
    *[("numpy", "<f2", 1j), ("array", "<f4", None, (1,), (1j,))],
    *[("other", "a" * 100, ""), ("other", 1, ""), ("html", "<b>"), (np.zeros(3),), ("none",) * 2],
]


@folded("told", HOSTILE, ids=lambda told: str(told)[:40])
def test_what_no_tracer_makes_is_refused(told: Any) -> None:
    with pytest.raises(MalformedTrace):
        values.read_value(told)


def test_what_is_nested_is_bounded() -> None:
    told: Any = ("none",)
    for _ in range(7):
        told = ("sequence", "list", None, 1, (told,))
    with pytest.raises(MalformedTrace):
        values.read_value(told)


def _mangled(piece: Any, chance: random.Random) -> Any:
    """The same with something of it replaced by something else."""
    if type(piece) is tuple and piece and chance.random() < 0.7:
        place = chance.randrange(len(piece))
        return (*piece[:place], _mangled(piece[place], chance), *piece[place + 1 :])
    return chance.choice([None, -1, 2**80, 1.5, True, "a" * 300, "step", (), (1,), [], {}, {"a": 1}, np.zeros(2)])


def test_whatever_is_told_is_read_or_refused_and_makes_a_trace_within_its_bounds() -> None:
    chance = random.Random(20)
    described = ValueDescriber().describe({"a": [1, np.eye(2)], "b": "c"})
    sound = [
        ("frame", "f", 1, None),
        ("step", "call", 0, 1, (("a", described),), (), (), ("", "")),
        ("frame", "g", 2, 0),
        ("step", "line", 1, 2, (("a", described), ("b", ("int", 1))), (), (), ("", "")),
        ("step", "exception", 1, 2, (), ("a",), (), ("E", "dit")),
        ("step", "return", 0, 3, (), (), (described,), ("", "")),
        ("left", "steps"),
    ]
    TraceReader(3).read_records(sound)
    for _ in range(1500):
        told, place = TraceReader(3), chance.randrange(len(sound))
        with suppress(MalformedTrace):
            told.read_records([*sound[:place], _mangled(sound[place], chance), *sound[place + 1 :]])
        assert all(1 <= step.line <= 3 and 0 <= step.frame < len(told.frames) for step in told.steps)
        assert all(frame.parent is None or frame.parent < k for k, frame in enumerate(told.frames))
        assert all(len(change.name) <= 200 for step in told.steps for change in step.changes)


def test_a_trace_of_which_every_character_is_spelled_out_stays_within_what_an_answer_may_hold() -> None:
    items: Any = ("sequence", "list", None, 250, (("text", "\x7f" * 200, 200),) * 250)
    told = TraceReader(1)
    told.read_records([("frame", "f", 1, None), *(("step", "line", 0, 1, (("a", items),), (), (), ("", "")),) * 100])
    assert 1 < len(told.steps) < 100
    assert told.omissions == ["nodes"]
    assert sum(len(step.model_dump_json().encode()) for step in told.steps) <= MAX_TRACE_BYTES
    with pytest.raises(MalformedTrace):
        _read_returned_value(((*items[:4], items[4] * 2), ()), shows_value=False)


def test_a_trace_is_json_that_the_schema_reads() -> None:
    told = TraceReader(2)
    told.read_records(
        [("frame", "f", 1, None), ("step", "call", 0, 1, (("a", arrived([np.eye(2)])),), (), (), ("", ""))]
    )
    trace = TraceOut.model_validate(
        {"lines": ["a", "b"], "filename": "f", "call": "", "frames": told.frames, "steps": told.steps, "mark": None}
        | {"end": {"kind": "cut"}, "left_out": [], "stdout": "", "milliseconds": 1}
    )
    assert TraceOut.model_validate_json(trace.model_dump_json()) == trace
