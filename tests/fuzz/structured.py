"""Structured fuzzing of the reading path with hypothesis: almost-values, almost-faults, almost-frames.

    python tests/fuzz/structured.py 30000          # examples of each of the three properties

The suite runs the same properties on fewer examples (`tests/sandbox/test_reading.py`).
"""

from __future__ import annotations

import struct
import sys
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import Any

if __name__ == "__main__":
    sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

import numpy as np
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from server.sandbox import FaultKind
from server.sandbox.child import frames
from server.sandbox.child.codec import DTYPES, ValueLimits, encode
from tests.fuzz import reading

# Lengths that tell the truth are put by `_node`; these are the lies.
_lies = st.sampled_from([0, 1, 2, 255, 2**16, 2**31 - 1, 2**31, 2**32 - 1])
_junk = st.binary(max_size=12)


def _length(count: int, lie: int | None) -> bytes:
    return struct.pack("<I", count if lie is None else lie)


_often_true = st.none() | st.none() | st.none() | _lies
_leaf = st.one_of(
    st.sampled_from([b"N", b"T", b"F"]),
    st.binary(min_size=8, max_size=8).map(lambda data: b"i" + data),
    st.floats(width=64).map(lambda number: b"f" + struct.pack("<d", number)),
    st.binary(min_size=16, max_size=16).map(lambda data: b"c" + data),
    st.builds(lambda data, lie: b"I" + _length(len(data), lie) + data, st.binary(max_size=520), _often_true),
    st.builds(lambda text, lie: b"s" + _length(len(text), lie) + text, st.text().map(str.encode) | _junk, _often_true),
    _junk,
)


@st.composite
def _array(draw: st.DrawFn) -> bytes:
    code = draw(st.integers(0, len(DTYPES)))
    shape = draw(st.lists(st.integers(0, 3) | _lies, max_size=9))
    size = DTYPES[min(code, len(DTYPES) - 1)].itemsize
    for side in shape:
        size = min(size * side, 400)
    return (
        b"a"
        + struct.pack(f"<BB{len(shape)}I", code, len(shape), *shape)
        + draw(st.binary(min_size=size, max_size=size) | _junk)
    )


def _sequence(tag: bytes, items: list[bytes], lie: int | None) -> bytes:
    return tag + _length(len(items), lie) + b"".join(items)


def _mapping(items: list[tuple[bytes, bytes]], lie: int | None) -> bytes:
    return b"d" + _length(len(items), lie) + b"".join(_sequence(b"s", [], len(k)) + k + v for k, v in items)


def _containers(inner: st.SearchStrategy[bytes]) -> st.SearchStrategy[bytes]:
    items = st.lists(inner, max_size=4)
    pairs = st.lists(st.tuples(st.text("ab", max_size=2).map(str.encode), inner), max_size=4)
    return st.builds(_sequence, st.sampled_from([b"t", b"l"]), items, _often_true) | st.builds(
        _mapping, pairs, _often_true
    )


almost_values = st.recursive(_leaf | _array(), _containers, max_leaves=10)

_texts = st.one_of(
    st.text(max_size=30),
    st.text(max_size=700),
    st.sampled_from(
        [
            "",
            "cpu",
            "a|b|c",
            "type|[0][1]|f",
            "depth|[1]|f",
            "{0}",
            "«\0\x1b[2J\u202e",
            "'(' was never closed",
            "x" * 60_000,
        ]
    ),
    st.sampled_from(
        ["expected an indented block after 'if' on line 3", "unterminated string literal", "(unicode error) 'utf-8'"]
    ),
)
_kinds = st.sampled_from([str(kind) for kind in FaultKind])
_lines = st.integers(1, 50)
_odd_lines = st.none() | st.integers(-(2**70), 2**70) | st.booleans() | st.floats()
_frames = st.lists(st.tuples(_lines, _texts, _texts), max_size=3).map(tuple)
_odd_frames = (
    st.lists(st.tuples(_odd_lines | _lines, _texts, _texts), max_size=9).map(tuple) | _texts | st.lists(_texts)
)
_fields = {
    "kind": _kinds,
    "exception": _texts,
    "text": _texts,
    "line": _lines | st.none(),
    "frames": _frames,
    "detail": _texts,
}
_odd_values: st.SearchStrategy[Any] = (
    st.none() | st.lists(_texts, max_size=1) | st.just({}) | st.just(np.zeros(2)) | st.floats()
)
_odd_fields = {
    "kind": _texts | _odd_values,
    "detail": _odd_values,
    "exception": _lines,
    "text": _lines,
    "line": _odd_lines,
    "frames": _odd_frames,
}
almost_faults: st.SearchStrategy[dict[str, Any]] = st.one_of(
    st.fixed_dictionaries(_fields),
    *(st.fixed_dictionaries(_fields | {name: odd}) for name, odd in _odd_fields.items()),
    st.dictionaries(st.sampled_from([*_fields, "autre"]), _texts | _lines),
)


@st.composite
def almost_frames(draw: st.DrawFn) -> bytes:
    payload = draw(
        almost_values
        | almost_faults.map(lambda fault: encode(fault, ValueLimits(1 << 20, 8, 1000)))
        | almost_values.map(lambda value: b"t\2\0\0\0" + value + b"N")
    )
    kind = draw(
        st.sampled_from([frames.VALUE, frames.FAULT, frames.VALUE, frames.FAULT, frames.READY, frames.ANOMALY, 255])
    )
    whole = reading.framed(payload, kind, draw(_often_true)) + draw(st.just(b"") | st.just(b"") | _junk)
    return whole[: draw(st.none() | st.none() | st.integers(0, len(whole)))]


def decoded(data: bytes) -> None:
    reading.decode_soundly(data)


def told(fault: dict[str, Any]) -> None:
    reading.tell_soundly(encode(fault, ValueLimits(1 << 20, 8, 1000)))


def answered(data: bytes, loading: bool, status: int) -> None:
    reading.converse_soundly(data, loading=loading, status=reading.status(status))


def tests(examples: int) -> dict[str, Callable[[], None]]:
    """The properties, to be called, on so many examples each."""
    thorough = settings(max_examples=examples, deadline=None, database=None, suppress_health_check=list(HealthCheck))
    return {
        "decoded": thorough(given(almost_values)(decoded)),
        "told": thorough(given(almost_faults)(told)),
        "answered": thorough(given(almost_frames(), st.booleans(), st.integers(0, 7))(answered)),
    }


def main(examples: str) -> None:
    for name, test in tests(int(examples)).items():
        tracemalloc.start()
        start = time.monotonic()
        test()
        tracemalloc.stop()
        print(f"{name}: {examples} examples in {time.monotonic() - start:.0f} s, no property broken")


if __name__ == "__main__":
    main(*sys.argv[1:])
