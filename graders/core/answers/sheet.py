"""What is wrong in a sheet: the questions of an exercise as students read them."""

from __future__ import annotations


class MalformedSheetError(Exception):
    """A sheet that does not hold together: why, and where in its file (`at`: the keys and places that lead there)."""

    def __init__(self, message: str, at: tuple[int | str, ...] = ()) -> None:
        super().__init__(message)
        self.message, self.at = message, at
