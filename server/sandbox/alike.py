"""Answers alike: most are one number or one array of floats, of the same shape as in the answer before.

Of one whose bytes are those of an answer that was decoded, but for the numbers, only these are read.
"""

from __future__ import annotations

import numpy as np

from server.sandbox.child.codec import Value
from server.sandbox.child.plain import FLOAT

_FLOATS = np.dtype("<f8")
#: After the numbers stands that no arguments have come back: null.
_AFTER = 1


class Alike:
    """The form of the last answer of a session that has one; `bytes` and `items` are what it takes of the session's."""

    def __init__(self) -> None:
        self._before, self._after, self.bytes = b"", b"", -1
        self._shape: tuple[int, ...] | None = None
        self._count = self.items = 0

    def learn(self, answer: bytes, decoded: Value, items: int) -> None:
        """Takes the form of an answer that the decoder has read, where it is one."""
        if type(decoded) is not tuple or len(decoded) != 2 or decoded[1] is not None:
            return
        value = decoded[0]
        if type(value) is float:
            shape, numbers = None, FLOAT.size
        elif type(value) is np.ndarray and value.dtype == np.float64:
            shape, numbers = value.shape, value.nbytes
        else:
            return
        begins = len(answer) - _AFTER - numbers
        self._before, self._after, self.bytes = answer[:begins], answer[len(answer) - _AFTER :], len(answer)
        self._shape, self._count, self.items = shape, numbers // FLOAT.size, items

    def fits(self, answer: bytes | bytearray, begins: int, ends: int) -> bool:
        """Whether the answer that stands between these places has this form."""
        return (
            ends - begins == self.bytes
            and answer.startswith(self._before, begins, ends)
            and answer.endswith(self._after, begins, ends)
        )

    def numbers(self, answer: bytes | bytearray, begins: int) -> Value:
        """The value of an answer that fits, from where it begins."""
        begins += len(self._before)
        if self._shape is None:
            return float(FLOAT.unpack_from(answer, begins)[0])
        return np.frombuffer(answer, _FLOATS, self._count, begins).reshape(self._shape).astype(np.float64)

    def read(self, answer: bytes) -> Value:
        """The value of an answer of this form; None for any other, which the decoder must read."""
        return self.numbers(answer, 0) if self.fits(answer, 0, len(answer)) else None
