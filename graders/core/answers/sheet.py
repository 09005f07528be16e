"""The error of a malformed sheet: the questions of an exercise as students read them."""

from __future__ import annotations


class MalformedSheetError(Exception):
    """A sheet is inconsistent: why, and where in its file (`at`: the path of keys and indices)."""

    def __init__(self, message: str, at: tuple[int | str, ...] = ()) -> None:
        super().__init__(message)
        self.message, self.at = message, at
