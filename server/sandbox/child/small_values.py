"""A faster path of `codec` for small values: the same bytes, the same values, the same errors.

Most calls of the course's functions carry a few floats or small arrays of floats, and there may be thousands of them.
Whatever is of another type, too big, or malformed goes to `codec`, which says why.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from typing import Any

import numpy as np

from . import codec
from .codec import Value, ValueLimits

#: Bounds of a small value: within all limits under which calls travel.
_MAX_BYTES, _MAX_DEPTH, _MAX_ITEMS = 1 << 14, 8, 256
_FLOATS = np.dtype(np.float64)
_FLOATS_CODE = codec.DTYPES.index(_FLOATS.newbyteorder("<"))
_TAGGED_FLOAT, _TAGGED_INT, _TAGGED_LENGTH = struct.Struct("<cd"), struct.Struct("<cq"), struct.Struct("<cI")
_VECTOR, _MATRIX = struct.Struct("<cBBI"), struct.Struct("<cBBII")
_unpack_float = struct.Struct("<d").unpack_from
_unpack_int = struct.Struct("<q").unpack_from
_unpack_length = struct.Struct("<I").unpack_from
_unpack_sides = struct.Struct("<II").unpack_from


class _NeedsGeneralCodecError(ValueError):
    """Something that the general codec must see."""


#: Failures of the fast path: the general codec gives the value, or the reason why there is none.
_FAILURES = (ValueError, LookupError, OverflowError, struct.error)


def encode(value: object, limits: ValueLimits) -> bytes:
    """Encode as `codec.encode` does."""
    pieces: list[bytes] = []
    try:
        _encode_all((value,), pieces.append, pieces, 1)
    except _FAILURES:
        return codec.encode(value, limits)
    return b"".join(pieces)


def _encode_all(values: Iterable[Any], write: Callable[[bytes], None], pieces: list[bytes], depth: int) -> None:
    if depth > _MAX_DEPTH or len(pieces) > _MAX_ITEMS:
        raise _NeedsGeneralCodecError
    for value in values:
        kind = type(value)
        if kind is float or kind is np.float64:
            write(_TAGGED_FLOAT.pack(b"f", value))
        elif kind is np.ndarray:
            write(_encode_array(value))
        elif kind is int:
            write(_TAGGED_INT.pack(b"i", value))
        elif kind is tuple or kind is list:
            if len(value) > _MAX_ITEMS:
                raise _NeedsGeneralCodecError
            write(_TAGGED_LENGTH.pack(b"t" if kind is tuple else b"l", len(value)))
            _encode_all(value, write, pieces, depth + 1)
        else:
            _encode_other(value, write, pieces, depth)


def _encode_other(value: Any, write: Callable[[bytes], None], pieces: list[bytes], depth: int) -> None:
    if type(value) is str:
        _encode_text(value, write)
    elif type(value) is dict:
        write(_TAGGED_LENGTH.pack(b"d", len(value)))
        for key, item in value.items():
            if type(key) is not str:
                raise _NeedsGeneralCodecError
            _encode_text(key, write)
            _encode_all((item,), write, pieces, depth + 1)
    elif value is None or type(value) is bool:
        write({None: b"N", True: b"T", False: b"F"}[value])
    else:
        raise _NeedsGeneralCodecError


def _encode_text(text: str, write: Callable[[bytes], None]) -> None:
    data = text.encode()
    if len(data) > _MAX_BYTES:
        raise _NeedsGeneralCodecError
    write(_TAGGED_LENGTH.pack(b"s", len(data)) + data)


def _encode_array(array: Any) -> bytes:
    if array.dtype != _FLOATS or array.nbytes > _MAX_BYTES:
        raise _NeedsGeneralCodecError
    if array.ndim == 1:
        return _VECTOR.pack(b"a", _FLOATS_CODE, 1, len(array)) + bytes(array.tobytes())
    if array.ndim == 2:
        return _MATRIX.pack(b"a", _FLOATS_CODE, 2, *array.shape) + bytes(array.tobytes())
    raise _NeedsGeneralCodecError


def decode(data: bytes, limits: ValueLimits) -> Value:
    """Decode as `codec.decode` does; the bytes may be hostile."""
    if len(data) <= _MAX_BYTES:
        try:
            values, end = _decode_all(data, 0, 1, 1)
            if end == len(data):
                return values[0]
        except _FAILURES:
            pass
    return codec.decode(data, limits)


def _decode_all(data: bytes, at: int, count: int, depth: int) -> tuple[list[Value], int]:
    """Return `count` values from the position `at`, and the position after them."""
    if depth > _MAX_DEPTH or count > _MAX_ITEMS:
        raise _NeedsGeneralCodecError
    values: list[Value] = []
    for _ in range(count):
        tag = data[at]
        at += 1
        if tag == _FLOAT:
            values += _unpack_float(data, at)
            at += 8
        elif tag == _ARRAY:
            array, at = _decode_array(data, at)
            values.append(array)
        elif tag == _INT:
            values += _unpack_int(data, at)
            at += 8
        elif tag == _TUPLE:
            items, at = _decode_all(data, at + 4, _unpack_length(data, at)[0], depth + 1)
            values.append(tuple(items))
        elif tag == _LIST:
            items, at = _decode_all(data, at + 4, _unpack_length(data, at)[0], depth + 1)
            values.append(items)
        elif tag == _TEXT:
            text, at = _decode_text(data, at)
            values.append(text)
        elif tag == _DICT:
            table, at = _decode_dict(data, at, depth)
            values.append(table)
        else:
            values.append(_CONSTANTS[tag])
    return values, at


def _decode_text(data: bytes, at: int) -> tuple[str, int]:
    end = at + 4 + _unpack_length(data, at)[0]
    if end > len(data):
        raise _NeedsGeneralCodecError
    return data[at + 4 : end].decode(), end


def _decode_array(data: bytes, at: int) -> tuple[codec.Array, int]:
    code, dimensions = data[at], data[at + 1]
    if code != _FLOATS_CODE:
        raise _NeedsGeneralCodecError
    if dimensions == 1:
        (length,) = _unpack_length(data, at + 2)
        return np.frombuffer(data, _FLOATS, length, at + 6).copy(), at + 6 + 8 * length
    if dimensions == 2:
        rows, columns = _unpack_sides(data, at + 2)
        size = rows * columns
        return np.frombuffer(data, _FLOATS, size, at + 10).reshape(rows, columns).copy(), at + 10 + 8 * size
    raise _NeedsGeneralCodecError


def _decode_dict(data: bytes, at: int, depth: int) -> tuple[dict[str, Value], int]:
    (count,) = _unpack_length(data, at)
    at += 4
    table: dict[str, Value] = {}
    for _ in range(count):
        if data[at] != _TEXT:
            raise _NeedsGeneralCodecError
        key, at = _decode_text(data, at + 1)
        if key in table:
            raise _NeedsGeneralCodecError
        (table[key],), at = _decode_all(data, at, 1, depth + 1)
    return table, at


_FLOAT, _ARRAY, _INT, _TUPLE, _LIST, _TEXT, _DICT = b"faitlsd"
_CONSTANTS: dict[int, bool | None] = {ord("N"): None, ord("T"): True, ord("F"): False}
