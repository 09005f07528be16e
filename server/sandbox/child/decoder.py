"""From the bytes of the wire to exact base types. Runs in the trusted process, on bytes that may be hostile."""

from __future__ import annotations

import struct
from collections.abc import Callable

import numpy as np

from .wire_values import (
    COMPLEX,
    DTYPES,
    FLOAT,
    INT,
    LENGTH,
    MAX_DIMENSIONS,
    MAX_INT_BYTES,
    NATIVE,
    Array,
    MalformedValue,
    TooManyItems,
    Value,
    ValueLimits,
)


class _ByteReader:
    def __init__(self, data: bytes, limits: ValueLimits) -> None:
        self.data = data
        self.at = 0
        self.limits = limits
        self.items = 0

    def take_bytes(self, length: int) -> bytes:
        end = self.at + length
        if end > len(self.data):
            raise MalformedValue("cut short")
        piece = self.data[self.at : end]
        self.at = end
        return piece

    def count_item(self) -> None:
        self.items += 1
        if self.items > self.limits.items:
            raise TooManyItems("too many items")

    def read_length(self) -> int:
        return int(LENGTH.unpack(self.take_bytes(4))[0])

    def read_item_count(self) -> int:
        """Number of items to come: each takes a byte at least, so the bytes left bound it."""
        count = self.read_length()
        if count > len(self.data) - self.at:
            raise MalformedValue("more items than bytes")
        if self.items + count > self.limits.items:  # told before any of them is read
            raise TooManyItems("too many items")
        return count


def decode(data: bytes, limits: ValueLimits) -> Value:
    """The value of these bytes, made of exact base types; arrays are owned, C-contiguous, native and writable.

    Raises Malformed, and nothing else, for bytes that are not one whole value within the limits.
    """
    return decode_counted(data, limits)[0]


def decode_counted(data: bytes, limits: ValueLimits) -> tuple[Value, int]:
    """As `decode`, with the number of items that the value is made of: an array is one, the key of a dict is one."""
    if len(data) > limits.size:
        raise MalformedValue("too long")
    reader = _ByteReader(data, limits)
    value = _decode(reader, 1)
    if reader.at != len(data):
        raise MalformedValue("bytes left over")
    return value, reader.items


def _decode(reader: _ByteReader, depth: int) -> Value:
    reader.count_item()
    if depth > reader.limits.depth:
        raise MalformedValue("too deep")
    decoder = _DECODERS.get(reader.take_bytes(1))
    if decoder is None:
        raise MalformedValue("unknown tag")
    return decoder(reader, depth)


def _decode_int(reader: _ByteReader, depth: int) -> int:
    return int(INT.unpack(reader.take_bytes(8))[0])


def _decode_big_int(reader: _ByteReader, depth: int) -> int:
    length = reader.read_length()
    if length > MAX_INT_BYTES:
        raise MalformedValue("integer too long")
    return int.from_bytes(reader.take_bytes(length), "little", signed=True)


def _decode_float(reader: _ByteReader, depth: int) -> float:
    return float(FLOAT.unpack(reader.take_bytes(8))[0])


def _decode_complex(reader: _ByteReader, depth: int) -> complex:
    return complex(*COMPLEX.unpack(reader.take_bytes(16)))


def _decode_str(reader: _ByteReader, depth: int) -> str:
    try:
        return reader.take_bytes(reader.read_length()).decode("utf-8")
    except UnicodeDecodeError as error:
        raise MalformedValue("text is not UTF-8") from error


def _decode_array(reader: _ByteReader, depth: int) -> Array:
    code, dimensions = reader.take_bytes(2)
    if code >= len(DTYPES) or dimensions > MAX_DIMENSIONS:
        raise MalformedValue("unknown array")
    shape = struct.unpack(f"<{dimensions}I", reader.take_bytes(4 * dimensions))
    nonzero = size = DTYPES[code].itemsize
    for side in shape:
        nonzero *= max(side, 1)
        size *= side
        if nonzero > 2**48:
            raise MalformedValue("array too big")
    flat = np.frombuffer(reader.take_bytes(size), dtype=np.uint8 if code == 0 else DTYPES[code])
    if code == 0 and flat.size and flat.max() > 1:
        raise MalformedValue("bool that is neither 0 nor 1")
    return flat.reshape(shape).astype(NATIVE[code])


def _decode_tuple(reader: _ByteReader, depth: int) -> tuple[Value, ...]:
    return tuple([_decode(reader, depth + 1) for _ in range(reader.read_item_count())])


def _decode_list(reader: _ByteReader, depth: int) -> list[Value]:
    return [_decode(reader, depth + 1) for _ in range(reader.read_item_count())]


def _decode_dict(reader: _ByteReader, depth: int) -> dict[str, Value]:
    result: dict[str, Value] = {}
    for _ in range(reader.read_item_count()):
        if reader.take_bytes(1) != b"s":
            raise MalformedValue("key is not text")
        reader.count_item()
        key = _decode_str(reader, depth)
        if key in result:
            raise MalformedValue("key given twice")
        result[key] = _decode(reader, depth + 1)
    return result


_DECODERS: dict[bytes, Callable[[_ByteReader, int], Value]] = {
    b"N": lambda reader, depth: None,
    b"T": lambda reader, depth: True,
    b"F": lambda reader, depth: False,
    b"i": _decode_int,
    b"I": _decode_big_int,
    b"f": _decode_float,
    b"c": _decode_complex,
    b"s": _decode_str,
    b"a": _decode_array,
    b"t": _decode_tuple,
    b"l": _decode_list,
    b"d": _decode_dict,
}
