"""From Python objects to the bytes of the wire: among a student's objects, or on the trusted side for questions."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Sequence
from typing import Any

import numpy as np

from .wire_values import (
    COMPLEX,
    DTYPE_CODE,
    FLOAT,
    INT,
    LENGTH,
    MAX_DIMENSIONS,
    MAX_INT_BYTES,
    Array,
    UnsendableValue,
    ValueLimits,
    ValueTooBig,
)

_FLOATS = np.dtype("<f8")
#: Header of a tuple of two.
_PAIR_HEADER = b"t" + LENGTH.pack(2)


class _Writer:
    def __init__(self, limits: ValueLimits) -> None:
        self.out = bytearray()
        self.limits = limits
        self.items = 0

    def write(self, data: bytes | memoryview) -> None:
        if len(self.out) + len(data) > self.limits.size:
            raise ValueTooBig("size")
        self.out += data

    def count_node(self, depth: int) -> None:
        self.items += 1
        if self.items > self.limits.items:
            raise ValueTooBig("items")
        if depth > self.limits.depth:
            raise ValueTooBig("depth")


def encode(value: object, limits: ValueLimits) -> bytes:
    """Return the bytes of a value. Raises Unsendable for an object that is none, TooBig beyond the limits."""
    writer = _Writer(limits)
    _encode(writer, value, 1, "")
    return bytes(writer.out)


def encode_returned(value: Any, limits: ValueLimits) -> bytes:
    """Encode (value, None), the form of most answers; fast for a float or an array of floats."""
    kind, encoded = type(value), b""
    if kind is float or kind is np.float64:
        encoded = _PAIR_HEADER + b"f" + FLOAT.pack(value) + b"N"
    elif kind is np.ndarray and value.dtype == _FLOATS and _is_within(value, limits):
        shape = struct.pack(f"<BB{value.ndim}I", DTYPE_CODE[_FLOATS], value.ndim, *value.shape)
        encoded = b"".join((_PAIR_HEADER, b"a", shape, value.tobytes(), b"N"))
    if encoded and len(encoded) <= limits.size and limits.depth >= 2 and limits.items >= 3:
        return encoded
    return encode((value, None), limits)


def encode_columns(columns: Sequence[Array]) -> bytes:
    """Encode a trusted tuple of arrays of floats."""
    pieces = [b"t" + LENGTH.pack(len(columns))]
    for column in columns:
        shape = struct.pack(f"<BB{column.ndim}I", DTYPE_CODE[_FLOATS], column.ndim, *column.shape)
        pieces += (b"a", shape, column.tobytes())
    return b"".join(pieces)


def _is_within(array: Array, limits: ValueLimits) -> bool:
    return 0 < array.ndim <= MAX_DIMENSIONS and array.nbytes < limits.size


def _encode(writer: _Writer, value: object, depth: int, path: str) -> None:
    writer.count_node(depth)
    encoder = _ENCODERS.get(type(value)) or _encoder_of_base_type(value)
    if encoder is None:
        _convert_and_encode(writer, value, depth, path)
    else:
        encoder(writer, value, depth, path)


def _encoder_of_base_type(value: object) -> Callable[[_Writer, Any, int, str], None] | None:
    """Return the encoder of the base type of an instance of a subclass."""
    for kind in (bool, int, float, complex, str, np.ndarray, np.generic, tuple, list, dict):
        if isinstance(value, kind):
            return _ENCODERS[kind]
    return None


def _encode_none(writer: _Writer, value: None, depth: int, path: str) -> None:
    writer.write(b"N")


def _encode_bool(writer: _Writer, value: bool, depth: int, path: str) -> None:
    writer.write(b"T" if value else b"F")


def _encode_int(writer: _Writer, value: int, depth: int, path: str) -> None:
    value = int.__index__(value)
    if -(2**63) <= value < 2**63:
        writer.write(b"i" + INT.pack(value))
        return
    size = value.bit_length() // 8 + 1
    if size > MAX_INT_BYTES:
        raise UnsendableValue("int", "int", path)
    writer.write(b"I" + LENGTH.pack(size) + value.to_bytes(size, "little", signed=True))


def _encode_float(writer: _Writer, value: float, depth: int, path: str) -> None:
    writer.write(b"f" + FLOAT.pack(float.__float__(value)))


def _encode_complex(writer: _Writer, value: complex, depth: int, path: str) -> None:
    writer.write(b"c" + COMPLEX.pack(value.real, value.imag))


def _encode_str(writer: _Writer, value: str, depth: int, path: str) -> None:
    data = str.encode(value, "utf-8", "replace")
    writer.write(b"s" + LENGTH.pack(len(data)))
    writer.write(data)


def _encode_generic(writer: _Writer, value: Any, depth: int, path: str) -> None:
    """A numpy scalar: a Python number, or text."""
    plain = value.item()
    if isinstance(plain, np.generic):  # longdouble
        plain = complex(plain) if isinstance(value, np.complexfloating) else float(plain)
    encoder = _ENCODERS.get(type(plain))
    if encoder is None:
        raise UnsendableValue("type", type(value).__name__, path)
    encoder(writer, plain, depth, path)


def _encode_array(writer: _Writer, value: Array, depth: int, path: str) -> None:
    plain = np.asarray(value).view(np.ndarray)
    if plain.ndim == 0 and plain.dtype.kind != "O":
        return _encode_generic(writer, plain[()], depth, path)
    if plain.ndim > MAX_DIMENSIONS:
        raise ValueTooBig("depth")
    if plain.size * plain.itemsize > writer.limits.size:
        raise ValueTooBig("size")
    if plain.dtype.kind == "O" and any(isinstance(item, np.ndarray) for item in plain.flat):
        return _encode_list(writer, list(plain), depth, path)
    plain = _to_wire_dtype(plain, path)
    shape = struct.pack(f"<BB{plain.ndim}I", DTYPE_CODE[plain.dtype], plain.ndim, *plain.shape)
    writer.write(b"a" + shape)
    return writer.write(plain.tobytes())


def _to_wire_dtype(array: Array, path: str) -> Array:
    """Convert to a dtype of the wire: longdouble becomes float64, objects that are numbers become numbers."""
    if array.dtype.kind == "O":
        array = _numbers_of_objects(array, path)
    little = array.dtype.newbyteorder("<")
    if little in DTYPE_CODE:
        return array.astype(little, copy=False)
    for kind, wide in (("f", "<f8"), ("c", "<c16"), ("i", "<i8"), ("u", "<u8")):
        if array.dtype.kind == kind:
            return array.astype(wide)
    raise UnsendableValue("dtype", str(array.dtype), path)


def _numbers_of_objects(array: Array, path: str) -> Array:
    for kinds, dtype in (((bool, np.bool_), "bool"), ((int, np.integer), "i8"), ((int, float, np.number), "f8")):
        if all(isinstance(item, kinds) for item in array.flat):
            return array.astype(dtype)
    if all(isinstance(item, (int, float, complex, np.number)) for item in array.flat):
        return array.astype("c16")
    raise UnsendableValue("object", "object", path)


def _encode_tuple(writer: _Writer, value: tuple[object, ...], depth: int, path: str) -> None:
    _encode_sequence(writer, b"t", tuple.__len__(value), tuple.__iter__(value), depth, path)


def _encode_list(writer: _Writer, value: list[object], depth: int, path: str) -> None:
    _encode_sequence(writer, b"l", list.__len__(value), list.__iter__(value), depth, path)


def _encode_sequence(writer: _Writer, tag: bytes, length: int, items: Iterator[object], depth: int, path: str) -> None:
    if writer.items + length > writer.limits.items:
        raise ValueTooBig("items")
    writer.write(tag + LENGTH.pack(length))
    for index, item in enumerate(items):
        _encode(writer, item, depth + 1, f"{path}[{index}]")


def _encode_dict(writer: _Writer, value: dict[object, object], depth: int, path: str) -> None:
    writer.write(b"d" + LENGTH.pack(dict.__len__(value)))
    for key, item in dict.items(value):
        if not isinstance(key, str):
            raise UnsendableValue("key", type(key).__name__, path)
        writer.count_node(depth)
        _encode_str(writer, key, depth, path)
        _encode(writer, item, depth + 1, f"{path}[{str.__str__(key)[:40]!r}]")


def _convert_and_encode(writer: _Writer, value: object, depth: int, path: str) -> None:
    """Encode an object that converts to a value: a range, a sparse matrix, an object with `__array__`."""
    if type(value) is range:
        if len(value) > writer.limits.items:
            raise ValueTooBig("items")
        _encode_list(writer, list(value), depth, path)
    elif type(value).__module__.startswith("scipy.sparse") and hasattr(value, "toarray"):
        if np.prod(getattr(value, "shape", ()), dtype=float) * 8 > writer.limits.size:
            raise ValueTooBig("size")
        _encode_array(writer, value.toarray(), depth, path)
    elif hasattr(type(value), "__array__"):
        _encode_array(writer, np.asarray(value), depth, path)
    else:
        raise UnsendableValue("type", type(value).__name__, path)


_ENCODERS: dict[type, Callable[[_Writer, Any, int, str], None]] = {
    type(None): _encode_none,
    bool: _encode_bool,
    int: _encode_int,
    float: _encode_float,
    complex: _encode_complex,
    str: _encode_str,
    np.ndarray: _encode_array,
    np.generic: _encode_generic,
    np.float64: _encode_float,
    tuple: _encode_tuple,
    list: _encode_list,
    dict: _encode_dict,
}
