"""Retrieval questions of a lesson: short, with fresh numbers, answered by a number or a choice. Pure.

A course's file `rappels/<lesson>.py` has one function for each question: `drift(rng)` draws its numbers and returns a
`RetrievalQuestion`, whose texts are plain French with `code` in backquotes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from hashlib import blake2b

import numpy as np

from graders.core.answers.letters import Letters
from graders.core.answers.numbers import NotANumberError, read_number
from graders.core.compare.words import number

#: A number is right within this share of it, unless its question says otherwise.
RELATIVE_TOLERANCE = 0.01
FEWEST_OPTIONS, MOST_OPTIONS = 2, 5
Answer = float | str


@dataclass(frozen=True)
class WrongAnswer:
    """An answer that a known mistake leads to, and the reason why it is wrong."""

    answer: Answer
    why: str


@dataclass(frozen=True)
class RetrievalQuestion:
    """A question with its numbers. Texts as answers make it a choice; numbers are typed, unless `is_choice`.

    `why` explains the right answer. `unit` is written after a number; `tolerance` is absolute, in that unit.
    """

    text: str
    answer: Answer
    why: str
    wrong: tuple[WrongAnswer, ...]
    unit: str = ""
    tolerance: float | None = None
    is_choice: bool = False

    @property
    def offers_options(self) -> bool:
        return self.is_choice or isinstance(self.answer, str)

    def answer_text(self, answer: Answer) -> str:
        """Return an answer as it is written for a reader."""
        words = answer if isinstance(answer, str) else number(answer, 4)
        return f"{words}\u00a0{self.unit}" if self.unit and not isinstance(answer, str) else words

    def options(self, seed: int) -> Sequence[tuple[str, str]]:
        """Return the options of a choice as letters and words, in the order that a seed gives them."""
        by_letter = self._option_letters(seed).by_letter
        answers = {str(place): self.answer_text(answer) for place, answer in enumerate(self._all_answers)}
        return [(letter, answers[place]) for letter, place in by_letter.items()]

    def mark(self, typed: str, seed: int) -> Marking:
        """Judge a typed number, or the letter of an option. Raises UnreadableAnswerError."""
        if self.offers_options:
            place = self._option_letters(seed).by_letter.get(typed.strip())
            if place is None:
                raise UnreadableAnswerError("Choisissez l’une des réponses proposées.")
            return self._mark_answer_at(int(place))
        try:
            value = read_number(typed)
        except NotANumberError as error:
            raise UnreadableAnswerError(f"Votre réponse n’est pas lue : {error}.") from error
        near = (place for place, answer in enumerate(self._all_answers) if self._is_near(value, answer))
        return self._mark_answer_at(next(near, None))

    def accepts(self, value: float) -> bool:
        """Return whether a number is the right answer, within its tolerance."""
        return self._is_near(value, self.answer)

    @property
    def _all_answers(self) -> Sequence[Answer]:
        return (self.answer, *(wrong.answer for wrong in self.wrong))

    def _option_letters(self, seed: int) -> Letters:
        return Letters.from_seed([str(place) for place in range(len(self._all_answers))], seed, "rappel")

    def _is_near(self, value: float, answer: Answer) -> bool:
        assert not isinstance(answer, str), "texts are options"
        tolerance = RELATIVE_TOLERANCE * abs(answer) if self.tolerance is None else self.tolerance
        return abs(value - answer) <= tolerance + 1e-12

    def _mark_answer_at(self, place: int | None) -> Marking:
        if place == 0:
            return Marking(True, self.why)
        right = f"La réponse était {self.answer_text(self.answer)}."
        if self.offers_options and isinstance(self.answer, str):
            right = f"La réponse était : « {self.answer} »."
        reason = "" if place is None else self.wrong[place - 1].why
        return Marking(False, " ".join(filter(None, (reason, right, self.why))))


@dataclass(frozen=True)
class Marking:
    """Whether an answer is right, and the words that say why."""

    is_right: bool
    why: str


class UnreadableAnswerError(Exception):
    """The text is no answer to the question; `args[0]` says why, in French."""


DrawQuestion = Callable[[np.random.Generator], RetrievalQuestion]


def draw_question(question: DrawQuestion, seed: int) -> RetrievalQuestion:
    """Return a question with the numbers of a seed."""
    return question(np.random.default_rng(seed))


def make_seed(*parts: str) -> int:
    """Return the seed of an account, a question and a day, as texts."""
    return int.from_bytes(blake2b("\0".join(parts).encode(), digest_size=6).digest(), "big")


def find_question_fault(question: RetrievalQuestion) -> str:
    """Return what is wrong with a drawn question, in French, or an empty string."""
    answers = (question.answer, *(wrong.answer for wrong in question.wrong))
    texts = (question.text, question.why, *(wrong.why for wrong in question.wrong))
    if not all(text.strip() for text in texts):
        return "il manque un texte : la question, ce qui explique la réponse, ou la raison d’une réponse fausse"
    if len({isinstance(answer, str) for answer in answers}) > 1:
        return "les réponses sont toutes des nombres, ou toutes des textes"
    if not all(isinstance(answer, str) or math.isfinite(answer) for answer in answers):
        return "une réponse n’est pas un nombre fini"
    return _find_choice_fault(question, answers) if question.offers_options else _find_number_fault(question, answers)


def _find_choice_fault(question: RetrievalQuestion, answers: Sequence[Answer]) -> str:
    if not FEWEST_OPTIONS <= len(answers) <= MOST_OPTIONS:
        return f"de {FEWEST_OPTIONS} à {MOST_OPTIONS} réponses proposées ; il y en a {len(answers)}"
    words = [question.answer_text(answer) for answer in answers]
    return "deux réponses proposées s’écrivent pareil" if len(set(words)) < len(words) else ""


def _find_number_fault(question: RetrievalQuestion, answers: Sequence[Answer]) -> str:
    if not question.wrong:
        return "aucune réponse fausse n’est expliquée"
    wrong = [number(answer) for answer in answers[1:] if not isinstance(answer, str) and question.accepts(answer)]
    return f"{wrong[0]} est compté juste, à la tolérance près" if wrong else ""
