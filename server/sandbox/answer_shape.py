"""Answers alike: most are one number or one array of floats, of the same shape as in the answer before.

Of one whose bytes are those of an answer that was decoded, but for the numbers, only these are read.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from server.sandbox.child.codec import Array, Value
from server.sandbox.child.frames import HEADER
from server.sandbox.child.wire_values import FLOAT
from server.sandbox.values import split_rows

_FLOATS = np.dtype("<f8")
#: After the numbers stands that no arguments have come back: null.
_AFTER = 1
NO_VALUES: Array = np.zeros(0)


class AnswerShape:
    """The form of the last answer of a session that has one; `bytes` and `items` are what it takes of the session's."""

    def __init__(self) -> None:
        self._before, self._after, self.answer_bytes = b"", b"", -1
        self._shape: tuple[int, ...] | None = None
        self._strides: tuple[int, ...] = ()
        self.items = 0

    def learn(self, answer: bytes, decoded: Value, items: int) -> None:
        """Takes the form of an answer that the decoder has read, where it is one."""
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
        """The value of an answer of this form; None for any other, which the decoder must read."""
        fits = len(answer) == self.answer_bytes and answer.startswith(self._before) and answer.endswith(self._after)
        return split_rows(self._values(answer, 1, 0, self.answer_bytes))[0] if fits else None

    def values_in(self, held: bytearray, at: int, tokens: Sequence[int], kind: int) -> Array:
        """The values (n, …) of the frames that stand one after the other from `at` on, as far as they are there, are of
        this kind and this form, and carry these tokens in this order."""
        stride, begins, came = HEADER.size + self.answer_bytes, at, 0
        if not self._before:
            return NO_VALUES
        for token in tokens[: (len(held) - at) // stride]:
            head = HEADER.pack(self.answer_bytes, token, kind) + self._before
            if not held.startswith(head, begins) or not held.startswith(self._after, begins + stride - _AFTER):
                break
            begins, came = begins + stride, came + 1
        return self._values(held, came, at + HEADER.size, stride) if came else NO_VALUES

    def _values(self, held: bytes | bytearray, count: int, at: int, stride: int) -> Array:
        """Of so many answers that have this form, the first at this place, each a stride after the one before."""
        shape, strides = (count, *(self._shape or ())), (stride, *self._strides)
        return np.ndarray(shape, _FLOATS, held, at + len(self._before), strides).astype(np.float64)
