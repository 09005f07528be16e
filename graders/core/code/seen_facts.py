"""Facts that experiments establish on the answers of one function, in words."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import partial
from typing import NamedTuple

import numpy as np

from graders.core.compare import words as render
from graders.core.compare.changed_arguments import ArgumentChange
from graders.core.compare.series import (
    MANY_CALLS,
    MIN_WRONG,
    Series,
    same,
    tell_own_relations,
    tell_relations,
)
from graders.core.compare.told_apart import value_text_pair
from graders.core.contract.program import KitSettings
from graders.core.contract.values import Arguments, Floats, Value
from graders.typography import elided

#: Characters of a value that is shown.
MAX_SHOWN = 120
DIGITS = 5
#: Calls in which a result must feel an argument, and does not, or the other way round.
MIN_FELT = 2


class FactKind(Enum):
    """What a fact says: what the answers are, or only where or in what they are wrong; for which other argument they
    are right; that they feel one wrongly; a failed call beside a near one that comes out right."""

    ANSWERS, FLAW, REPLACED, FELT, CONTRAST = "answers", "flaw", "replaced", "felt", "contrast"


@dataclass(frozen=True)
class SeenFact:
    """A fact on the answers of one function: a title, the sentences that prove it, a question, and its kind."""

    function: str
    title: str
    proof: str
    question: str
    kind: FactKind

    @property
    def says_answers(self) -> bool:
        """Whether it says what the answers are, and not only where they are wrong."""
        return self.kind is FactKind.ANSWERS


@dataclass(frozen=True)
class ReturnedValue:
    """A value among those that a function returns, or a row or a column of it, with its name in French."""

    words: str
    read: Callable[[Sequence[Floats]], Floats]


@dataclass(frozen=True)
class FunctionTrial:
    """One function under trial: its calls with their kit, and the answers of both programs."""

    function: str
    names: tuple[str, ...]
    parts: tuple[str, ...]
    kit: KitSettings
    calls: Sequence[Arguments]
    got: Sequence[Sequence[Floats]]
    right: Sequence[Sequence[Floats]]
    unrounded: Sequence[Sequence[Floats]] = ()
    #: Whether the solution's answers are the only right ones.
    unique: bool = True

    def make_series(self, view: ReturnedValue) -> Series:
        got, right = [view.read(row) for row in self.got], [view.read(row) for row in self.right]
        wrong = [not same(mine, its) for mine, its in zip(got, right, strict=True)]
        return Series(self.names, self.calls, got, right, wrong, [view.read(row) for row in self.unrounded])

    def plainest_call_number(self, numbers: Iterable[int]) -> int:
        """Return the number of the call with the fewest numbers in its arguments."""
        return min(numbers, key=self.count_argument_numbers)

    def count_argument_numbers(self, number: int) -> int:
        """Return how many numbers the arguments of a call have."""
        return sum(map(_count_values, self.calls[number]))

    def wrong_views(self) -> list[ReturnedValue]:
        """Return the values that are wrong in several calls."""
        views = [
            ReturnedValue(self._subject_text(part), partial(_select_part, part)) for part in range(len(self.right[0]))
        ]
        return [view for view in views if sum(self.make_series(view).wrong) >= MIN_WRONG]

    def _subject_text(self, part: int) -> str:
        return f"« {self.parts[part]} », que renvoie {self.function}," if self.parts else self.function

    def call_text(self, call: Arguments) -> str:
        return " ; ".join(f"{name} = {value_text(value)}" for name, value in zip(self.names, call, strict=False))


def _count_values(value: Value) -> int:
    """Return how many numbers and texts an argument has, whatever its form: rows may be of different lengths."""
    if isinstance(value, np.ndarray):
        return value.size
    if isinstance(value, dict):
        return sum(map(_count_values, value.values()))
    return sum(map(_count_values, value)) if isinstance(value, list | tuple) else 1


def _select_part(part: int, values: Sequence[Floats]) -> Floats:
    return values[part]


def iter_columns(trial: FunctionTrial, view: ReturnedValue) -> Iterator[ReturnedValue]:
    """Yield the columns of a table of two or three, where each is wrong or right by itself."""
    series = trial.make_series(view)
    counts = {array.shape[1:] for arrays in (series.got, series.right) for array in arrays}
    if len(counts) != 1 or (count := counts.pop()) not in ((2,), (3,)) or series.right[0].ndim != 2:
        return
    for column in range(count[0]):
        words = f"dans ce que renvoie {trial.function}, la colonne {column}"
        yield ReturnedValue(words, partial(_select_column, view, column))


def _select_column(view: ReturnedValue, column: int, values: Sequence[Floats]) -> Floats:
    return view.read(values)[:, column]


@dataclass(frozen=True)
class VariedCall:
    """A call with one argument varied: the argument's index, the change, the number of the call, its new arguments."""

    index: int
    change: ArgumentChange
    number: int
    call: Arguments


class VariedAnswers(NamedTuple):
    """A variation, and a value that both programs return before and after."""

    variation: VariedCall
    got: Floats
    mine: Floats
    right: Floats
    wanted: Floats


_QUESTION = "Quelle ligne de votre fonction peut donner cela ?"
REPLACED = "À quelles lignes cet argument entre-t-il dans le calcul, et sous quelle forme ?"
FELT = "Où votre fonction se sert-elle de cet argument, et ce qu’elle en fait arrive-t-il jusqu’au résultat ?"
NOT_FELT = "Que faudrait-il retrancher, diviser ou ramener, pour que cela ne compte plus ?"


def find_relation(trial: FunctionTrial, view: ReturnedValue) -> SeenFact | None:
    series = trial.make_series(view)
    tell = tell_relations if trial.unique and len(trial.calls) >= MANY_CALLS else tell_own_relations
    relation = next(tell(series), None)
    if relation is None:
        return None
    k = trial.plainest_call_number(number for number, wrong in enumerate(series.wrong) if wrong)
    tries, wrong, example = len(trial.calls), sum(series.wrong), "" if trial.unique else " par exemple"
    title = f"{sentence_subject(view.words)} {relation.words}"
    right, got = shown_value_pair(series.right[k], series.got[k])
    seen = f"C’est ainsi dans les {tries} essais{f', dont {wrong} faux' if wrong < tries else ''}."
    if not relation.says_what:
        seen = f"Sur {tries} essais, {wrong} sont faux."
    proof = (
        f"{seen} Par exemple, pour {trial.call_text(trial.calls[k])}, on attend{example} {right} et on obtient {got}."
    )
    kind = FactKind.ANSWERS if relation.says_what else FactKind.FLAW
    return SeenFact(trial.function, title, proof, _QUESTION, kind)


def replaced_argument_fact(
    trial: FunctionTrial, view: ReturnedValue, number: int, change: ArgumentChange, call: Arguments
) -> SeenFact:
    """Return the fact that a value is what is awaited for changed arguments, as in this call."""
    series, example = trial.make_series(view), "" if trial.unique else ", par exemple,"
    failed_call = trial.call_text(trial.calls[number])
    right, got = shown_value_pair(series.right[number], series.got[number])
    proof = (
        f"C’est ainsi dans les {len(trial.calls)} essais. Pour {failed_call}, on attend{example} {right} et on obtient "
        f"{got} : ce que l’on "
        f"attend{example} pour {trial.call_text(call)}."
    )
    title = f"{sentence_subject(view.words)} est ce que l’on attend si {change.words}"
    return SeenFact(trial.function, title, proof, REPLACED, FactKind.REPLACED)


def are_right_answers_whole(rows: Sequence[VariedAnswers]) -> bool:
    """Whether all right answers are whole numbers, as indices are: one may depend on an argument and not move."""
    return all(bool(np.all(right == np.round(right))) for row in rows for right in (row.right, row.wanted))


def has_wrong_influence(rows: Sequence[VariedAnswers]) -> bool | None:
    """Whether a result feels what it must not; False where it does not feel what it must, None where neither is so."""
    must = [not same(row.wanted, row.right) for row in rows]
    moved = [not same(row.mine, row.got) for row in rows]
    if sum(must) >= MIN_FELT and not any(moved):
        return False
    return True if len(rows) > MIN_FELT and sum(moved) >= MIN_FELT and not any(must) else None


def influence_fact(
    trial: FunctionTrial, view: ReturnedValue, row: VariedAnswers, rows: Sequence[VariedAnswers], question: str
) -> SeenFact:
    """Return the fact that a value changes with an argument in some calls, of these `rows`, and should in others or
    none; `row` is told."""
    moved = sum(not same(each.mine, each.got) for each in rows)
    must = sum(not same(each.wanted, each.right) for each in rows)
    does = f"change dans {moved}" if moved else "ne change dans aucun"
    should = f"il devrait dans {must}" if must else "il ne devrait dans aucun"
    change = re.sub("^on ", "l’on ", row.variation.change.words)
    title = f"{sentence_subject(view.words)} {does} des {len(rows)} essais où {change} : {should}"
    before, after = trial.call_text(trial.calls[row.variation.number]), trial.call_text(row.variation.call)
    (right, got), (wanted, mine) = shown_value_pair(row.right, row.got), shown_value_pair(row.wanted, row.mine)
    proof = (
        f"Pour {before}, on attend {right} et on obtient {got} ; pour {after}, on attend {wanted} et on obtient {mine}."
    )
    return SeenFact(trial.function, title, proof, question, FactKind.FELT)


def sentence_subject(words: str) -> str:
    return f"{words[:1].upper()}{words[1:]}" if " " in words else f"Le résultat {elided('de', words)}"


def value_text(value: Value) -> str:
    return _cut_text(render.text(value, digits=DIGITS))


def shown_value_pair(expected: Value, got: Value) -> tuple[str, str]:
    """Return two values as `value_text` writes them, with the digits that tell their numbers apart."""
    first, second = value_text_pair(expected, got, digits=DIGITS)
    return _cut_text(first), _cut_text(second)


def _cut_text(text: str) -> str:
    return text if len(text) <= MAX_SHOWN else f"{text[: MAX_SHOWN - 1]}…"
