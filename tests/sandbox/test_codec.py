"""The codec of the wire: exact types out, whatever goes in; malformed bytes are refused and cost nothing."""

from __future__ import annotations

import math
import struct
from collections import OrderedDict, namedtuple
from collections.abc import Callable
from enum import IntEnum
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from server.sandbox.child.codec import DTYPES, MalformedValue, UnsendableValue, ValueLimits, ValueTooBig, decode, encode

LIMITS = ValueLimits(size=1 << 20, depth=16, items=10_000)


def object_array(*items: object) -> Any:
    array = np.empty(len(items), dtype=object)
    array[:] = items
    return array


def roundtrip(value: object) -> Any:
    return decode(encode(value, LIMITS), LIMITS)


def same(left: Any, right: Any) -> bool:
    """Equality that looks at types, and tells 0.0 from -0.0; NaN equals itself."""
    return type(left) is type(right) and _COMPARISONS.get(type(left), lambda a, b: bool(a == b))(left, right)


def same_floats(left: float, right: float) -> bool:
    return struct.pack("d", left) == struct.pack("d", right) or (math.isnan(left) and math.isnan(right))


def same_items(left: Any, right: Any) -> bool:
    return len(left) == len(right) and all(map(same, left, right))


_COMPARISONS: dict[type, Callable[[Any, Any], bool]] = {
    float: same_floats,
    complex: lambda a, b: same_floats(a.real, b.real) and same_floats(a.imag, b.imag),
    list: same_items,
    tuple: same_items,
    dict: lambda a, b: list(a) == list(b) and same_items(list(a.values()), list(b.values())),
    np.ndarray: lambda a, b: a.dtype == b.dtype and a.shape == b.shape and a.tobytes() == b.tobytes(),
}


numbers = st.none() | st.booleans() | st.integers(-(2**4000), 2**4000) | st.floats() | st.complex_numbers()
scalars = numbers | st.text(st.characters(exclude_categories=["Cs"]))
native = st.sampled_from([dtype.newbyteorder("=") for dtype in DTYPES])
arrays = native.flatmap(lambda dtype: hnp.arrays(dtype, hnp.array_shapes(min_dims=1, min_side=0, max_side=4)))
values = st.recursive(
    scalars | arrays,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.lists(inner, max_size=4).map(tuple)
        | st.dictionaries(st.text("abé"), inner, max_size=4)
    ),
    max_leaves=12,
)


@given(values)
@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_what_goes_in_comes_out_with_its_exact_types(value: Any) -> None:
    assert same(roundtrip(value), value)


@given(arrays)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_arrays_come_out_owned_contiguous_native_and_writable(array: Any) -> None:
    out = roundtrip(np.asfortranarray(array)[::-1])
    assert type(out) is np.ndarray
    assert out.flags.c_contiguous
    assert out.flags.owndata
    assert out.flags.writeable
    assert out.dtype.isnative
    assert same(out, np.ascontiguousarray(array[::-1]))


class _Colour(IntEnum):
    RED = 3


class _Loud(float):
    def __float__(self) -> float:
        raise AssertionError("asked the subclass")


class _Subclass(np.ndarray):  # type: ignore[type-arg]
    __eq__ = __ne__ = lambda self, other: True  # type: ignore[assignment]


class _Arraylike:
    def __array__(self, dtype: object = None, copy: object = None) -> Any:
        return np.array([1.0, 2.0])


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (np.float32(0.5), 0.5),
        (np.float64(0.5), 0.5),
        (np.longdouble(0.5), 0.5),
        (np.clongdouble(0.5j), 0.5j),
        (np.int16(-3), -3),
        (np.bool_(True), True),
        (np.str_("é"), "é"),
        (np.array(2.5), 2.5),
        (np.array([1, 2], dtype=object), np.array([1, 2])),
        (np.array([1, 2.5], dtype=object), np.array([1.0, 2.5])),
        (np.array([True, False], dtype=object), np.array([True, False])),
        (np.array([1, 2j], dtype=object), np.array([1, 2j])),
        (object_array(np.eye(2), np.ones(2)), [np.eye(2), np.ones(2)]),
        (np.array([1.5], dtype=np.longdouble), np.array([1.5])),
        (np.array([1.5, 2.5], dtype=">f8"), np.array([1.5, 2.5])),
        (np.arange(2.0).view(_Subclass), np.arange(2.0)),
        (np.ma.array([1.0, 2.0]), np.array([1.0, 2.0])),
        (range(3), [0, 1, 2]),
        (namedtuple("Pose", "x y")(1, 2), (1, 2)),
        (OrderedDict(a=1), {"a": 1}),
        (_Colour.RED, 3),
        (_Loud(1.5), 1.5),
        (_Arraylike(), np.array([1.0, 2.0])),
        ("\ud800", "?"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_what_looks_like_a_value_becomes_one(given: object, expected: object) -> None:
    assert same(roundtrip(given), expected)


def test_a_sparse_matrix_becomes_an_array() -> None:
    sparse = pytest.importorskip("scipy.sparse")
    assert same(roundtrip(sparse.csr_matrix(np.eye(2))), np.eye(2))


@pytest.mark.parametrize(
    ("given", "reason"),
    [
        ({1, 2}, "type"),
        ((i for i in range(3)), "type"),
        (b"octets", "type"),
        (Fraction(1, 3), "type"),
        (len, "type"),
        ({1: 2}, "key"),
        (np.array(["a"]), "dtype"),
        (np.array([None, 1]), "object"),
        (np.array(["2020-01-01"], dtype="M8[D]"), "dtype"),
        (1 << 10_000, "int"),
    ],
    ids=lambda value: type(value).__name__,
)
def test_the_rest_is_refused_with_its_type_and_place(given: object, reason: str) -> None:
    with pytest.raises(UnsendableValue) as caught:
        encode([0, given], LIMITS)
    assert caught.value.reason == reason
    assert caught.value.path == "[1]"


@pytest.mark.parametrize(
    ("given", "what"),
    [
        (np.zeros(1 << 18), "size"),
        ("x" * (1 << 21), "size"),
        ([0] * 10_001, "items"),
        (range(10**12), "items"),
        (np.broadcast_to(np.float64(0), (1 << 20, 1 << 20)), "size"),
    ],
    ids=["array", "text", "list", "range", "broadcast"],
)
def test_beyond_the_bounds_is_too_big(given: object, what: str) -> None:
    with pytest.raises(ValueTooBig) as caught:
        encode(given, LIMITS)
    assert caught.value.what == what


def test_a_value_that_contains_itself_is_too_deep() -> None:
    loop: list[object] = []
    loop.append(loop)
    with pytest.raises(ValueTooBig, match="depth"):
        encode(loop, LIMITS)


def array_bytes(code: int, shape: tuple[int, ...], data: bytes = b"") -> bytes:
    return b"a" + struct.pack(f"<BB{len(shape)}I", code, len(shape), *shape) + data


FLOAT64 = [str(dtype) for dtype in DTYPES].index("float64")


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"?",
        b"f\0\0",
        b"NN",
        b"s\xff\xff\xff\xffabc",
        b"s\x01\0\0\0\xff",
        b"t\xff\xff\xff\xff",
        b"I\xff\xff\xff\x7f",
        b"l\x01\0\0\0" * 17 + b"N",
        b"l\x01\0\0\0" * 100_000 + b"N",
        b"d\x02\0\0\0" + b"s\x01\0\0\0aN" * 2,
        b"d\x01\0\0\0NN",
        array_bytes(200, (1,), b"\0" * 8),
        array_bytes(0, (1,), b"\x02"),
        array_bytes(FLOAT64, (2,), b"\0" * 8),
        array_bytes(FLOAT64, (1,), b"\0" * 16),
        array_bytes(FLOAT64, (2**32 - 1,) * 8),
        array_bytes(FLOAT64, (0, *(2**32 - 1,) * 7)),
        b"a" + bytes([FLOAT64, 33]) + b"\1\0\0\0" * 33,
    ],
)
def test_bytes_that_are_no_value_are_refused(data: bytes) -> None:
    with pytest.raises(MalformedValue):
        decode(data, LIMITS)


def test_bytes_beyond_the_bound_are_refused_unread() -> None:
    with pytest.raises(MalformedValue):
        decode(encode(np.zeros(100), LIMITS), ValueLimits(size=100, depth=4, items=10))


class _Traps(np.ndarray):
    """Lies wherever numpy lets a subclass speak."""

    __array_priority__ = 1e9

    def __array_ufunc__(self, *_: object, **__: object) -> Any:
        raise AssertionError("asked the subclass")

    __array_function__ = __array_ufunc__
    tobytes = tolist = astype = item = __len__ = __iter__ = __array_ufunc__


class _Mapping(dict):
    def __init__(self, *args: Any) -> None:
        super().__init__(*args)

    def items(self) -> Any:
        raise AssertionError("asked the subclass")

    keys = values = __len__ = __iter__ = __getitem__ = items


class _List(list):
    def __iter__(self) -> Any:
        raise AssertionError("asked the subclass")

    __len__ = __getitem__ = __eq__ = __iter__
    __hash__ = None


class _Integer(int):
    def __index__(self) -> int:
        raise AssertionError("asked the subclass")

    __int__ = bit_length = to_bytes = __lt__ = __le__ = __ge__ = __gt__ = __index__


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (np.arange(3.0).view(_Traps), np.arange(3.0)),
        (_Mapping({"a": _Integer(3)}), {"a": 3}),
        (_List([1, _List([2])]), [1, [2]]),
        (_Integer(7), 7),
        (_Integer(2**70), 2**70),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_subclass_is_not_asked_what_it_is(given: object, expected: object) -> None:
    assert same(roundtrip(given), expected)
