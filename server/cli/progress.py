"""How far a long command is: one line on a terminal, which what it prints next replaces."""

from __future__ import annotations

import sys
from typing import Self, TextIO

_CLEAR = "\r\x1b[K"


class Progress:
    """`advance` as work gets done; nothing is written where nobody looks on. Closed, the line is gone."""

    def __init__(self, what: str, total: int, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._shown = self._stream.isatty()
        self._what, self._total, self._done = what, total, 0
        self._show()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.clear()

    def advance(self) -> None:
        self._done += 1
        self._show()

    def clear(self) -> None:
        """Leave the line to what is printed now."""
        if self._shown:
            self._stream.write(_CLEAR)
            self._stream.flush()

    def _show(self) -> None:
        if self._shown:
            self._stream.write(f"{_CLEAR}{self._what} : {self._done}/{self._total}")
            self._stream.flush()
