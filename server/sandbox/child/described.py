"""Libraries are imported without what they compose of their functions' descriptions meanwhile, for `help` to tell.

That is half of the time that importing scipy takes (it parses a thousand of them, to add a note to each), and a third
of matplotlib's. What is written in their sources stays.
"""

from __future__ import annotations

import importlib
from contextlib import suppress
from typing import Any


class AsWritten(dict[str, list[Any]]):
    """A description that scipy would parse, add to section by section, and put together again."""

    def __init__(self, function: object, *_: object, **__: object) -> None:
        super().__init__()
        self._text = function.__doc__ or ""

    def __missing__(self, section: str) -> list[Any]:
        return self.setdefault(section, [])

    def __str__(self) -> str:
        """Below a line of its own, where scipy expects the signature."""
        return f"\n{self._text}"


def leave_scipy_s() -> None:
    """For all that is imported of scipy from now on, if it is there."""
    with suppress(ModuleNotFoundError):
        importlib.import_module("scipy._lib._docscrape").FunctionDoc = AsWritten  # type: ignore[attr-defined]


def leave_matplotlib_s() -> None:
    """For all that is imported of it from now on: the properties of each kind of things that are drawn."""
    artist: Any = importlib.import_module("matplotlib.artist")
    artist.kwdoc = lambda _: ""
