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
    """The form of the last answer of a session that has one; `items` is what it takes of the session's."""

    def __init__(self) -> None:
        self._before, self._after, self._bytes = b"", b"", -1
        self._shape: tuple[int, ...] | None = None
        self.items = 0

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
        self._before, self._after, self._bytes = answer[:begins], answer[len(answer) - _AFTER :], len(answer)
        self._shape, self.items = shape, items

    def read(self, answer: bytes) -> Value:
        """The value of an answer of this form; None for any other, which the decoder must read."""
        if len(answer) != self._bytes or not answer.startswith(self._before) or not answer.endswith(self._after):
            return None
        begins = len(self._before)
        if self._shape is None:
            return float(FLOAT.unpack_from(answer, begins)[0])
        numbers = len(answer) - _AFTER - begins
        return (
            np.frombuffer(answer, _FLOATS, numbers // _FLOATS.itemsize, begins).reshape(self._shape).astype(np.float64)
        )
