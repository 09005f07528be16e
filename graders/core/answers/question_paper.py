"""The question paper of a student: the data of their variant and the questions in Markdown, without any answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Form = Literal["number", "one", "several", "order"]


@dataclass(frozen=True)
class GivenDatum:
    """One datum of the variant. `symbol` is TeX, `text` the number in French, rounded as it must be used."""

    symbol: str
    name: str
    text: str
    unit: str


@dataclass(frozen=True)
class PaperPiece:
    """An option or a step, under its letter in this variant."""

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
    """The data and questions of one variant."""

    given: tuple[GivenDatum, ...]
    questions: tuple[Question, ...]


@dataclass(frozen=True)
class AnswerTranscript:
    """The answer to a question in readable form: the typed text, or the chosen pieces."""

    question: str
    title: str
    text: str
    pieces: tuple[PaperPiece, ...] = ()


def quote_markdown(text: str) -> str:
    """Return a text as the inside of a Markdown quotation, whose first line follows the sign."""
    return text.strip().replace("\n", "\n> ")
