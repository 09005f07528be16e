"""A program's output in which the same line comes over and over, as a node's log does: such runs are folded."""

from __future__ import annotations

import re
from itertools import groupby

#: A time in brackets, as loggers write it before each line: « [1001.4] ».
_TIMESTAMP = re.compile(r"\[\d+\.\d+\]")
#: Runs of so many lines stay as they are.
_MOST_SHOWN = 3


def fold_repeated_lines(text: str) -> str:
    """Return the text with each run of more than three lines that differ by their timestamps alone folded.

    The first of them is left, and a line « … N fois encore ». Other numbers are no repetition: they may be what the
    program was made to print.
    """
    folded: list[str] = []
    for _, group in groupby(text.split("\n"), key=lambda line: _TIMESTAMP.sub("[]", line)):
        lines = list(group)
        is_folded = len(lines) > _MOST_SHOWN and lines[0].strip() != ""
        folded += [lines[0], f"… la même ligne, {len(lines) - 1} fois encore"] if is_folded else lines
    return "\n".join(folded)
