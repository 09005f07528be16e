"""Search in the text of a program."""

from __future__ import annotations


def find_or_end(text: str, sought: str, start: int, end: int | None = None) -> int:
    """Return the index of a character from `start` on, `end` (by default, that of the text) where there is none."""
    end = len(text) if end is None else end
    found = text.find(sought, start, end)
    return end if found < 0 else found


def find_end_of_string(text: str, start: int) -> int:
    """Return the index behind the string that begins at a quote."""
    quote = text[start] * 3 if text.startswith(text[start] * 3, start) else text[start]
    at = start + len(quote)
    while at < len(text):
        if text[at] == "\\":
            at += 2
        elif text.startswith(quote, at):
            return at + len(quote)
        elif len(quote) == 1 and text[at] == "\n":
            return at
        else:
            at += 1
    return len(text)
