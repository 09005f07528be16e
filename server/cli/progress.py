"""How far a long command is: one line on a terminal, which makes way for what is printed."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from threading import Lock
from typing import Self, TextIO

_CLEAR = "\r\x1b[K"


class ProgressLine:
    """`advance` as work gets done, from any thread; nothing is written where nobody looks on. Closed, it is gone."""

    def __init__(self, what: str, total: int, stream: TextIO | None = None) -> None:
        self._stream = stream or sys.stderr
        self._shown = self._stream.isatty()
        self._what, self._total, self._done = what, total, 0
        self._lock = Lock()

    def __enter__(self) -> Self:
        self._write(self._format_line())
        return self

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._write("")
            self._shown = False

    def advance(self) -> None:
        with self._lock:
            self._done += 1
            self._write(self._format_line())

    @contextmanager
    def cleared_for_print(self) -> Iterator[None]:
        """The line is gone as long as the block lasts, for something else to be printed there."""
        with self._lock:
            self._write("")
            try:
                yield
            finally:
                self._write(self._format_line())

    def _format_line(self) -> str:
        return f"{self._what} : {self._done}/{self._total}"

    def _write(self, line: str) -> None:
        if self._shown:
            self._stream.write(f"{_CLEAR}{line}")
            self._stream.flush()
