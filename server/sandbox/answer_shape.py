"""Fast path for answers of one shape: most answers are a float or an array of floats, shaped like the answer before.

Where all bytes but the numbers equal those of a decoded answer, only the numbers are read.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from server.sandbox.child.codec import Array, Value
from server.sandbox.child.frames import HEADER
from server.sandbox.child.wire_values import FLOAT
from server.sandbox.values import split_rows

_FLOATS = np.dtype("<f8")
#: Bytes after the numbers: the null that says that no arguments came back.
_AFTER = 1
NO_VALUES: Array = np.zeros(0)


class AnswerShape:
    """Shape of a session's last fixed-shape answer, which costs `answer_bytes` and `items` of the budgets."""

    def __init__(self) -> None:
        self._before, self._after, self.answer_bytes = b"", b"", -1
        self._shape: tuple[int, ...] | None = None
        self._strides: tuple[int, ...] = ()
        self.items = 0

    def learn(self, answer: bytes, decoded: Value, items: int) -> None:
        """Record the shape of a decoded answer, if it is a float or an array of floats."""
        if type(decoded) is not tuple or len(decoded) != 2 or decoded[1] is not None:
            return
        value = decoded[0]
        strides: tuple[int, ...] = ()
        shape: tuple[int, ...] | None = None
        if type(value) is float:
            numbers = FLOAT.size
        elif type(value) is np.ndarray and value.dtype == np.float64 and value.size:
            shape, strides, numbers = value.shape, value.strides, value.nbytes
        else:
            return
        begins = len(answer) - _AFTER - numbers
        self._before, self._after, self.answer_bytes = answer[:begins], answer[len(answer) - _AFTER :], len(answer)
        self._shape, self._strides, self.items = shape, strides, items

    def read(self, answer: bytes) -> Value:
        """Return the value of an answer of this shape; None for another one, which the decoder must read."""
        fits = len(answer) == self.answer_bytes and answer.startswith(self._before) and answer.endswith(self._after)
        return split_rows(self._values_at(answer, 1, 0, self.answer_bytes))[0] if fits else None

    def read_consecutive_values(self, buffer: bytearray, at: int, tokens: Sequence[int], kind: int) -> Array:
        """Return the values (n, …) of the complete consecutive frames from `at` on that have this kind and shape, and
        carry these tokens in this order."""
        stride, begins, came = HEADER.size + self.answer_bytes, at, 0
        if not self._before:
            return NO_VALUES
        for token in tokens[: (len(buffer) - at) // stride]:
            head = HEADER.pack(self.answer_bytes, token, kind) + self._before
            if not buffer.startswith(head, begins) or not buffer.startswith(self._after, begins + stride - _AFTER):
                break
            begins, came = begins + stride, came + 1
        return self._values_at(buffer, came, at + HEADER.size, stride) if came else NO_VALUES

    def _values_at(self, buffer: bytes | bytearray, count: int, at: int, stride: int) -> Array:
        """Return the values of `count` answers of this shape, the first at `at`, `stride` bytes apart."""
        shape, strides = (count, *(self._shape or ())), (stride, *self._strides)
        return np.ndarray(shape, _FLOATS, buffer, at + len(self._before), strides).astype(np.float64)
