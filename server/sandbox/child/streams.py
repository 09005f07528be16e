"""The student's standard output: a text stream without buffer over the shared memory file, silent beyond its bound."""

from __future__ import annotations

import builtins
import io
import os
import sys
from typing import Any

_PRINT_OPTIONS = frozenset({"sep", "end", "file", "flush"})


class BoundedBytes(io.RawIOBase):
    """Writes to a descriptor up to a limit in bytes, then drops the rest without an error."""

    def __init__(self, descriptor: int) -> None:
        self._descriptor, self._bound, self._full = descriptor, 0, False

    def set_limit(self, bound: int) -> None:
        self._bound = bound

    @property
    def is_full(self) -> bool:
        return self._full

    def writable(self) -> bool:
        return True

    def fileno(self) -> int:
        return self._descriptor

    def write(self, data: object) -> int:
        view = memoryview(data).cast("B")  # type: ignore[arg-type]
        if not self._full and len(view):
            self._write_within_limit(view)
        return len(view)

    def _write_within_limit(self, view: memoryview) -> None:
        room = self._bound - os.lseek(self._descriptor, 0, os.SEEK_CUR)
        if room > 0:
            os.write(self._descriptor, view[:room])
        self._full = room <= len(view)


class BoundedText(io.TextIOBase):
    """UTF-8 text over `BoundedBytes`; every write reaches the file at once, so that a killed program keeps it."""

    def __init__(self, raw: BoundedBytes) -> None:
        self._raw, self._bound = raw, 0

    def set_limit(self, bound: int) -> None:
        self._bound = bound
        self._raw.set_limit(bound)

    encoding = "utf-8"
    errors = "replace"

    @property
    def buffer(self) -> BoundedBytes:
        return self._raw

    def writable(self) -> bool:
        return True

    def reconfigure(self, **_: object) -> None:
        """Accepted, as on any text stream; this one stays in UTF-8 and without buffer."""

    def fileno(self) -> int:
        return self._raw.fileno()

    def write(self, text: str) -> int:
        if not isinstance(text, str):
            raise TypeError(f"write() argument must be str, not {type(text).__name__}")
        if not self._raw.is_full:
            self._raw.write(text[: self._bound + 1].encode("utf-8", "replace"))
            if self._raw.is_full:
                self._silence_print()
        return len(text)

    def _silence_print(self) -> None:
        """Have `print` format nothing more for this stream: a program that prints in its loops would spend its time on
        what nobody reads. It goes on to print elsewhere."""
        print_text = builtins.print

        def print_elsewhere(*values: Any, **options: Any) -> None:
            file = options.get("file")
            if (sys.stdout if file is None else file) is not self or not options.keys() <= _PRINT_OPTIONS:
                print_text(*values, **options)

        print_elsewhere.__name__ = print_elsewhere.__qualname__ = "print"
        builtins.print = print_elsewhere
