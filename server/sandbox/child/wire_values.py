"""Shared by the encoder and the decoder of the wire: values, their bounds, and errors."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Array: TypeAlias = npt.NDArray[Any]
Value: TypeAlias = (
    "bool | int | float | complex | str | Array | tuple[Value, ...] | list[Value] | dict[str, Value] | None"
)

DTYPES: tuple[np.dtype[Any], ...] = tuple(
    np.dtype(name).newbyteorder("<")
    for name in (
        *("bool", "int8", "int16", "int32", "int64", "uint8", "uint16", "uint32", "uint64"),
        *("float16", "float32", "float64", "complex64", "complex128"),
    )
)
DTYPE_CODE = {dtype: code for code, dtype in enumerate(DTYPES)}
NATIVE = tuple(dtype.newbyteorder("=") for dtype in DTYPES)
MAX_DIMENSIONS = 8
MAX_INT_BYTES = 512

LENGTH = struct.Struct("<I")
INT = struct.Struct("<q")
FLOAT = struct.Struct("<d")
COMPLEX = struct.Struct("<dd")


@dataclass(frozen=True)
class ValueLimits:
    """Bounds of one encoded value: bytes, nesting, number of nodes."""

    size: int
    depth: int
    items: int


class MalformedValue(ValueError):
    """The bytes are not a value within the limits."""


class TooManyItems(MalformedValue):
    """The bytes may be a value, of more items than the limits allow."""


class UnsendableValue(TypeError):
    """A Python object that is no value: `culprit` is its type, `path` its position (``[0]['a']``)."""

    def __init__(self, reason: str, culprit: str, path: str) -> None:
        super().__init__(reason, culprit, path)
        self.reason, self.culprit, self.path = reason, culprit, path


class ValueTooBig(ValueError):
    """A value beyond the limits; `what` is size, depth or items."""

    def __init__(self, what: str) -> None:
        super().__init__(what)
        self.what = what
