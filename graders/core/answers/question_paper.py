"""What a student is given: the data of their deal, the questions in Markdown, nothing that tells an answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Form = Literal["number", "one", "several", "order"]


@dataclass(frozen=True)
class GivenDatum:
    """One datum of the deal. `symbol` is TeX, `text` the number in French, as it is to be used."""

    symbol: str
    name: str
    text: str
    unit: str


@dataclass(frozen=True)
class PaperPiece:
    """An option, or a step, under the letter that this deal gives it."""

    id: str
    text: str


@dataclass(frozen=True)
class Question:
    """One question. `id` names its answer; `pieces` are in the order of their letters.

    `section` is the heading under which it stands, with the questions after it that have the same.
    """

    id: str
    title: str
    text: str
    form: Form
    points: float
    unit: str = ""
    pieces: tuple[PaperPiece, ...] = ()
    section: str = ""


@dataclass(frozen=True)
class Paper:
    """The questions of one deal."""

    given: tuple[GivenDatum, ...]
    questions: tuple[Question, ...]


@dataclass(frozen=True)
class AnswerTranscript:
    """The answer to a question, to be read again: as it was typed, or the pieces that were chosen."""

    question: str
    title: str
    text: str
    pieces: tuple[PaperPiece, ...] = ()


def quote_markdown(text: str) -> str:
    """A text of the sheet as the inside of a Markdown quotation: its first line follows the sign."""
    return text.strip().replace("\n", "\n> ")
