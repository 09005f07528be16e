"""A wrong and a right program side by side, without anything that identifies their authors: pure."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from difflib import SequenceMatcher

from server.board.extracts import anonymise_lines, find_function
from server.comments.difference import DiffRun, diff_lines

#: Two programs whose lines differ more than that show nothing beside each other but two styles.
MIN_LIKENESS = 0.5
#: So few differing lines are the wrong ones, also where none is proven.
MAX_DIFFERING = 2


@dataclass(frozen=True)
class ProgramLine:
    """A line of an extract; `marked`: it is (in the right program: replaces) a line that is wrong."""

    text: str
    marked: bool


@dataclass(frozen=True)
class Contrast:
    """The two extracts; `right` is empty where no right program may be shown. Nothing is marked that could be right."""

    wrong: tuple[ProgramLine, ...]
    right: tuple[ProgramLine, ...]


@dataclass(frozen=True)
class Extract:
    """The lines of an extract with their numbers from 1 in the whole program."""

    lines: tuple[tuple[int, str], ...]

    @property
    def texts(self) -> list[str]:
        return [text for _, text in self.lines]


def extract_lines(code: str, functions: Collection[str], people_words: Collection[str]) -> Extract:
    """Return the anonymised lines of the first of these functions; empty where the program has none."""
    start, text = find_function(code, functions)
    return Extract(tuple((start + index, line) for index, line in anonymise_lines(text, people_words)))


def contrast_with_most_alike(wrong: Extract, wrong_line: int | None, right: Sequence[Extract]) -> Contrast:
    """Put the most alike of the right extracts beside the wrong one.

    `wrong_line`: the line of the whole wrong program that is proven wrong, None where none is.
    """
    likest = max(right, key=lambda extract: text_similarity(wrong, extract), default=Extract(()))
    if text_similarity(wrong, likest) < MIN_LIKENESS:
        likest = Extract(())
    runs = [run for run in diff_lines(wrong.texts, likest.texts).runs if not run.is_equal]
    marked = [index for index, (number, _) in enumerate(wrong.lines) if number == wrong_line]
    differing = [index for run in runs for index in run.before]
    if not marked and likest.lines and len(differing) <= MAX_DIFFERING:
        marked = differing  # one is right, the other wrong, and nothing else differs
    answering = {index for run in runs if _run_touches_lines(run, marked) for index in run.after}
    return Contrast(
        tuple(ProgramLine(text, index in marked) for index, text in enumerate(wrong.texts)),
        tuple(ProgramLine(text, index in answering) for index, text in enumerate(likest.texts)),
    )


def text_similarity(first: Extract, second: Extract) -> float:
    """Return the share of equal text of two extracts, from 0 to 1."""
    if not first.lines or not second.lines:
        return 0.0
    return SequenceMatcher(None, "\n".join(first.texts), "\n".join(second.texts), autojunk=False).ratio()


def _run_touches_lines(run: DiffRun, lines: Sequence[int]) -> bool:
    return any(line in run.before for line in lines)
