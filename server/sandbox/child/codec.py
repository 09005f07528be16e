"""Values of the wire: null, bool, int, float, complex, str, array of a listed dtype, tuple, list, dict with str keys.

`encode` runs among a student's objects and turns what looks like one of these into one of these. `decode` runs in the trusted process
on bytes that may be hostile: it yields exact base types, or raises Malformed; it allocates nothing that the bytes do not fill.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[Any]
Value: TypeAlias = "None | bool | int | float | complex | str | Array | tuple[Value, ...] | list[Value] | dict[str, Value]"

DTYPES: tuple[np.dtype[Any], ...] = tuple(
    np.dtype(name).newbyteorder("<")
    for name in (
        *("bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"),
        *("float16", "float32", "float64", "complex64", "complex128"),
    )
)
_DTYPE_CODE = {dtype: code for code, dtype in enumerate(DTYPES)}
_NATIVE = tuple(dtype.newbyteorder("=") for dtype in DTYPES)
MAX_DIMENSIONS = 8
MAX_INT_BYTES = 512

_LENGTH = struct.Struct("<I")
_INT = struct.Struct("<q")
_FLOAT = struct.Struct("<d")
_COMPLEX = struct.Struct("<dd")


@dataclass(frozen=True)
class Limits:
    """Bounds of one encoded value: bytes, nesting, number of nodes."""

    size: int
    depth: int
    items: int


class Malformed(ValueError):
    """The bytes are not a value within the limits."""


class Unsendable(TypeError):
    """A Python object that is no value: `culprit` is its type, `place` where it was found."""

    def __init__(self, reason: str, culprit: str, place: str) -> None:
        super().__init__(reason, culprit, place)
        self.reason, self.culprit, self.place = reason, culprit, place


class TooBig(ValueError):
    """A value beyond the limits; `what` is size, depth or items."""

    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.what = what


# --- encoding -------------------------------------------------------------------------------------------------------


class _Writer:
    def __init__(self, limits: Limits) -> None:
        self.out = bytearray()
        self.limits = limits
        self.items = 0

    def write(self, data: bytes | memoryview) -> None:
        if len(self.out) + len(data) > self.limits.size:
            raise TooBig("size")
        self.out += data

    def node(self, depth: int) -> None:
        self.items += 1
        if self.items > self.limits.items:
            raise TooBig("items")
        if depth > self.limits.depth:
            raise TooBig("depth")


def encode(value: object, limits: Limits) -> bytes:
    """Bytes of a value. Raises Unsendable for an object that is none, TooBig beyond the limits."""
    writer = _Writer(limits)
    _encode(writer, value, 1, "")
    return bytes(writer.out)


def _encode(writer: _Writer, value: object, depth: int, place: str) -> None:
    writer.node(depth)
    encoder = _EXACT.get(type(value)) or _resembling(value)
    if encoder is None:
        _convert(writer, value, depth, place)
    else:
        encoder(writer, value, depth, place)


def _resembling(value: object) -> Callable[[_Writer, Any, int, str], None] | None:
    """Encoder of the base type that an instance of a subclass stands for."""
    for kind in (bool, int, float, complex, str, np.ndarray, np.generic, tuple, list, dict):
        if isinstance(value, kind):
            return _EXACT[kind]
    return None


def _encode_none(writer: _Writer, value: None, depth: int, place: str) -> None:
    writer.write(b"N")


def _encode_bool(writer: _Writer, value: bool, depth: int, place: str) -> None:
    writer.write(b"T" if value else b"F")


def _encode_int(writer: _Writer, value: int, depth: int, place: str) -> None:
    value = int.__index__(value)
    if -(2**63) <= value < 2**63:
        writer.write(b"i" + _INT.pack(value))
        return
    size = value.bit_length() // 8 + 1
    if size > MAX_INT_BYTES:
        raise Unsendable("int", "int", place)
    writer.write(b"I" + _LENGTH.pack(size) + value.to_bytes(size, "little", signed=True))


def _encode_float(writer: _Writer, value: float, depth: int, place: str) -> None:
    writer.write(b"f" + _FLOAT.pack(float.__float__(value)))


def _encode_complex(writer: _Writer, value: complex, depth: int, place: str) -> None:
    writer.write(b"c" + _COMPLEX.pack(value.real, value.imag))


def _encode_str(writer: _Writer, value: str, depth: int, place: str) -> None:
    data = str.encode(value, "utf-8", "replace")
    writer.write(b"s" + _LENGTH.pack(len(data)))
    writer.write(data)


def _encode_generic(writer: _Writer, value: np.generic, depth: int, place: str) -> None:
    """A numpy scalar: a Python number, or text."""
    plain = value.item()
    if isinstance(plain, np.generic):  # longdouble
        plain = complex(plain) if isinstance(value, np.complexfloating) else float(plain)
    encoder = _EXACT.get(type(plain))
    if encoder is None:
        raise Unsendable("type", type(value).__name__, place)
    encoder(writer, plain, depth, place)


def _encode_array(writer: _Writer, value: Array, depth: int, place: str) -> None:
    plain = np.asarray(value).view(np.ndarray)
    if plain.ndim == 0 and plain.dtype.kind != "O":
        return _encode_generic(writer, plain[()], depth, place)
    if plain.ndim > MAX_DIMENSIONS:
        raise TooBig("depth")
    if plain.size * plain.itemsize > writer.limits.size:
        raise TooBig("size")
    plain = _listed_dtype(plain, place)
    shape = struct.pack(f"<BB{plain.ndim}I", _DTYPE_CODE[plain.dtype], plain.ndim, *plain.shape)
    writer.write(b"a" + shape)
    return writer.write(plain.tobytes())


def _listed_dtype(array: Array, place: str) -> Array:
    """The same numbers in a dtype of the list: longdouble becomes float64, objects that are numbers become numbers."""
    if array.dtype.kind == "O":
        array = _numbers_of_objects(array, place)
    little = array.dtype.newbyteorder("<")
    if little in _DTYPE_CODE:
        return array.astype(little, copy=False)
    for kind, wide in (("f", "<f8"), ("c", "<c16"), ("i", "<i8"), ("u", "<u8")):
        if array.dtype.kind == kind:
            return array.astype(wide)
    raise Unsendable("dtype", str(array.dtype), place)


def _numbers_of_objects(array: Array, place: str) -> Array:
    for kinds, dtype in (((bool, np.bool_), "bool"), ((int, np.integer), "i8"), ((int, float, np.number), "f8")):
        if all(isinstance(item, kinds) for item in array.flat):
            return array.astype(dtype)
    if all(isinstance(item, (int, float, complex, np.number)) for item in array.flat):
        return array.astype("c16")
    raise Unsendable("object", "object", place)


def _encode_tuple(writer: _Writer, value: tuple[object, ...], depth: int, place: str) -> None:
    _encode_sequence(writer, b"t", tuple.__len__(value), tuple.__iter__(value), depth, place)


def _encode_list(writer: _Writer, value: list[object], depth: int, place: str) -> None:
    _encode_sequence(writer, b"l", list.__len__(value), list.__iter__(value), depth, place)


def _encode_sequence(
    writer: _Writer, tag: bytes, length: int, items: Iterator[object], depth: int, place: str
) -> None:
    if writer.items + length > writer.limits.items:
        raise TooBig("items")
    writer.write(tag + _LENGTH.pack(length))
    for index, item in enumerate(items):
        _encode(writer, item, depth + 1, f"{place}[{index}]")


def _encode_dict(writer: _Writer, value: dict[object, object], depth: int, place: str) -> None:
    writer.write(b"d" + _LENGTH.pack(dict.__len__(value)))
    for key, item in dict.items(value):
        if not isinstance(key, str):
            raise Unsendable("key", type(key).__name__, place)
        _encode_str(writer, key, depth, place)
        _encode(writer, item, depth + 1, f"{place}[{str.__str__(key)[:40]!r}]")


def _convert(writer: _Writer, value: object, depth: int, place: str) -> None:
    """What is not a value but stands for one: a range, a sparse matrix, an object that knows how to be an array."""
    if type(value) is range:
        if len(value) > writer.limits.items:
            raise TooBig("items")
        _encode_list(writer, list(value), depth, place)
    elif type(value).__module__.startswith("scipy.sparse") and hasattr(value, "toarray"):
        if np.prod(getattr(value, "shape", ()), dtype=float) * 8 > writer.limits.size:
            raise TooBig("size")
        _encode_array(writer, value.toarray(), depth, place)
    elif hasattr(type(value), "__array__"):
        _encode_array(writer, np.asarray(value), depth, place)
    else:
        raise Unsendable("type", type(value).__name__, place)


_EXACT: dict[type, Callable[[_Writer, Any, int, str], None]] = {
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


# --- decoding -------------------------------------------------------------------------------------------------------


class _Reader:
    def __init__(self, data: bytes, limits: Limits) -> None:
        self.data = data
        self.at = 0
        self.limits = limits
        self.items = 0

    def take(self, length: int) -> bytes:
        end = self.at + length
        if end > len(self.data):
            raise Malformed("cut short")
        piece = self.data[self.at : end]
        self.at = end
        return piece

    def length(self) -> int:
        return int(_LENGTH.unpack(self.take(4))[0])

    def count(self) -> int:
        """Number of items to come: each takes a byte at least, so the bytes left bound it."""
        count = self.length()
        if count > len(self.data) - self.at:
            raise Malformed("more items than bytes")
        return count


def decode(data: bytes, limits: Limits) -> Value:
    """The value of these bytes, made of exact base types; arrays are owned, C-contiguous, native and writable.

    Raises Malformed, and nothing else, for bytes that are not one whole value within the limits.
    """
    if len(data) > limits.size:
        raise Malformed("too long")
    reader = _Reader(data, limits)
    value = _decode(reader, 1)
    if reader.at != len(data):
        raise Malformed("bytes left over")
    return value


def _decode(reader: _Reader, depth: int) -> Value:
    reader.items += 1
    if reader.items > reader.limits.items or depth > reader.limits.depth:
        raise Malformed("too many items or too deep")
    decoder = _DECODERS.get(reader.take(1))
    if decoder is None:
        raise Malformed("unknown tag")
    return decoder(reader, depth)


def _decode_int(reader: _Reader, depth: int) -> int:
    return int(_INT.unpack(reader.take(8))[0])


def _decode_big_int(reader: _Reader, depth: int) -> int:
    length = reader.length()
    if length > MAX_INT_BYTES:
        raise Malformed("integer too long")
    return int.from_bytes(reader.take(length), "little", signed=True)


def _decode_float(reader: _Reader, depth: int) -> float:
    return float(_FLOAT.unpack(reader.take(8))[0])


def _decode_complex(reader: _Reader, depth: int) -> complex:
    return complex(*_COMPLEX.unpack(reader.take(16)))


def _decode_str(reader: _Reader, depth: int) -> str:
    try:
        return reader.take(reader.length()).decode("utf-8")
    except UnicodeDecodeError as error:
        raise Malformed("text is not UTF-8") from error


def _decode_array(reader: _Reader, depth: int) -> Array:
    code, dimensions = reader.take(2)
    if code >= len(DTYPES) or dimensions > MAX_DIMENSIONS:
        raise Malformed("unknown array")
    shape = struct.unpack(f"<{dimensions}I", reader.take(4 * dimensions))
    nonzero = size = DTYPES[code].itemsize
    for side in shape:
        nonzero *= max(side, 1)
        size *= side
        if nonzero > 2**48:
            raise Malformed("array too big")
    flat = np.frombuffer(reader.take(size), dtype=np.uint8 if code == 0 else DTYPES[code])
    if code == 0 and flat.size and flat.max() > 1:
        raise Malformed("bool that is neither 0 nor 1")
    return flat.reshape(shape).astype(_NATIVE[code])


def _decode_tuple(reader: _Reader, depth: int) -> tuple[Value, ...]:
    return tuple([_decode(reader, depth + 1) for _ in range(reader.count())])


def _decode_list(reader: _Reader, depth: int) -> list[Value]:
    return [_decode(reader, depth + 1) for _ in range(reader.count())]


def _decode_dict(reader: _Reader, depth: int) -> dict[str, Value]:
    result: dict[str, Value] = {}
    for _ in range(reader.count()):
        if reader.take(1) != b"s":
            raise Malformed("key is not text")
        key = _decode_str(reader, depth)
        if key in result:
            raise Malformed("key given twice")
        result[key] = _decode(reader, depth + 1)
    return result


_DECODERS: dict[bytes, Callable[[_Reader, int], Value]] = {
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
