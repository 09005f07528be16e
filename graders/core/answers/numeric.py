"""Questions answered by a number, on random data of each account (its variant)."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from graders.core.answers.interval import rounded_bounds_around
from graders.core.answers.judging import AnswerCheck, Answers, AnswersGrader
from graders.core.answers.mistakes import Mistake, check_same_mistakes, read_mistakes
from graders.core.answers.numbers import NotANumberError, check_finite, read_number
from graders.core.answers.quantity import Data, Formula, Quantity, Values
from graders.core.answers.question_paper import AnswerTranscript, GivenDatum, Paper, Question
from graders.core.answers.reading import display_text, is_blank
from graders.core.answers.rounding import TypedDecimal, decimals_for, parse_decimal
from graders.core.answers.sheet import MalformedSheetError
from graders.core.answers.wording import NumericSheet, NumericWording
from graders.core.compare.words import number
from graders.core.contract.definition import MODULE_FILE, Definition
from graders.core.contract.findings import Finding
from graders.core.contract.malformed import MalformedExerciseError
from graders.core.contract.streams import stream
from graders.core.contract.verdict import MAX_POINTS

MAX_DRAWS = 1000  # one deal in thirteen is kept in some exercises: an unlucky seed would stay so for ever
MIN_SEPARATION = 10  # tolerances between a slip and the right value, and between two slips
FOLLOWED = (
    "Votre calcul est juste, mais il part d'une de vos réponses précédentes qui ne l'est pas : "
    "une partie des points est gagnée."
)
ROUNDED = "C'est la bonne valeur, mais trop arrondie, et la moitié des points est gagnée"
DOUBTFUL = "Cette réponse est trop arrondie pour que l'on sache d'où elle vient"
NEARLY_RIGHT = 5  # tolerances from the right value that rounding on the way may explain
PARTIAL_CREDIT = 0.5  # of the points: for what follows from one's own wrong answer, and for too few digits


@dataclass(frozen=True)
class NumericDefinition(Definition):
    """See `numeric`."""

    catalogue: Mapping[str, Mistake]
    draw_data: Callable[[np.random.Generator], Data]
    quantities: tuple[Quantity, ...]

    def bind(self, sheet: NumericSheet) -> NumericGrader:
        """Return the grader. Raises MalformedExerciseError where definition and sheet disagree."""
        grader = NumericGrader(self.exercise, self.folder, self.catalogue, self.draw_data, self.quantities, sheet)
        question_ids, judged = (
            [question.id for question in sheet.questions],
            [quantity.id for quantity in self.quantities],
        )
        if question_ids != judged:
            raise MalformedExerciseError(
                self.file,
                f"ce correcteur juge {', '.join(judged)}, et questions.toml demande {', '.join(question_ids)}",
            )
        shown_data = {datum.name for datum in sheet.data}
        dealt = grader.data(0)
        if shown_data != dealt.keys():
            odd = sorted(shown_data ^ dealt.keys())
            raise MalformedExerciseError(
                self.file, f"nombres tirés par deal() et non montrés, ou l’inverse : {', '.join(odd)}"
            )
        for index, unknown in enumerate(sheet.unknown_placeholders()):
            if unknown:
                raise MalformedSheetError(
                    f"ces nombres ne sont pas tirés par deal() : {', '.join(unknown)}", ("question", index)
                )
        return grader


def numeric(
    file: str, *, deal: Callable[[np.random.Generator], Data], quantities: Sequence[Quantity]
) -> NumericDefinition:
    """Describe an exercise from its grader's module: `numeric(__file__, deal=…, quantities=…)`.

    `deal` gives the data, rounded as they are shown. Raises MalformedExerciseError.
    """
    folder = Path(file).parent
    catalogue = read_mistakes(folder)
    total = sum(quantity.points for quantity in quantities)
    if abs(total - MAX_POINTS) > 1e-9:
        raise MalformedExerciseError(
            Path(file), f"les questions font {total:g} points : changez-les pour qu’elles en fassent {MAX_POINTS:g}"
        )
    check_same_mistakes(folder, catalogue, {slip for quantity in quantities for slip in quantity.slips})
    return NumericDefinition(folder, catalogue, deal, tuple(quantities))


@dataclass(frozen=True)
class NumericVariant:
    """One variant: the data, the right values, and the value of each slip by question."""

    data: Data
    right: Values
    slips: Mapping[str, Mapping[str, float]]


@dataclass(frozen=True, eq=False)
class NumericGrader(AnswersGrader):
    draw_data: Callable[[np.random.Generator], Data]
    quantities: tuple[Quantity, ...]
    sheet: NumericSheet

    def data(self, seed: int) -> Data:
        return _deal_variant(self, seed).data

    def paper(self, seed: int) -> Paper:
        data = self.data(seed)
        data_shown = tuple(
            GivenDatum(datum.symbol, datum.meaning, datum.text(data[datum.name]), datum.unit)
            for datum in self.sheet.data
        )
        questions = tuple(
            Question(w.id, w.title, self.sheet.fill_placeholders(w.text, data), "number", q.points, w.unit)
            for w, q in zip(self.sheet.questions, self.quantities, strict=True)
        )
        return Paper(data_shown, questions)

    def checks(self) -> Sequence[AnswerCheck]:
        pairs = zip(self.sheet.questions, self.quantities, strict=True)
        return [
            AnswerCheck(question.id, question.title, quantity.points, question.hint or None)
            for question, quantity in pairs
        ]

    def right_answers(self, seed: int) -> Answers:
        return {name: float(value) for name, value in _deal_variant(self, seed).right.items()}

    def judge(self, answers: Answers, seed: int) -> Sequence[Finding]:
        dealt, findings = _deal_variant(self, seed), []
        own = dict(dealt.right)
        for check, quantity in zip(self.checks(), self.quantities, strict=True):
            raw = answers.get(quantity.id)
            value = _read_number_or_reason(raw)
            if raw is None:
                findings.append(check.blank())
            elif isinstance(value, float):
                findings.append(self._judge_value(check, quantity, value, raw, dealt, own, seed))
                own[quantity.id] = value
            else:
                findings.append(check.unreadable(value, raw))
        return findings

    def _judge_value(
        self,
        check: AnswerCheck,
        quantity: Quantity,
        value: float,
        raw: Any,
        dealt: NumericVariant,
        own: Values,
        seed: int,
    ) -> Finding:
        right = dealt.right[quantity.id]
        if quantity.is_within_tolerance(value, right):
            return check.passed()
        followed = _evaluate_formula(quantity.expected, dealt.data, own)
        worked = value != 0.0  # zeros follow from zeros without any calculation
        shown_as: dict[str, Any] = {
            "inputs": {datum.name: dealt.data[datum.name] for datum in self.sheet.data},
            "expected": self._expected_interval_text(quantity.id, right, seed),
            "got": display_text(raw),
        }
        if (
            worked
            and followed is not None
            and not quantity.is_within_tolerance(followed, right)
            and quantity.is_within_tolerance(value, followed)
        ):
            return check.failed(FOLLOWED, points=PARTIAL_CREDIT * quantity.points, **shown_as)
        few = parse_decimal(raw, value)
        if few is not None and few.is_rounding_of(right):
            message, wanted, points = self._judge_rounded_value(quantity, few, dealt, own)
            return check.without_hint.failed(message, points=points, **{**shown_as, "expected": wanted})
        slip = self._find_slip(quantity, value, dealt, own)
        if slip:
            return check.failed(self.catalogue[slip].brief_text, slip=slip, **shown_as)
        return check.failed(_wrong_value_message(quantity, value, right), **shown_as)

    def _judge_rounded_value(
        self, quantity: Quantity, few: TypedDecimal, dealt: NumericVariant, own: Values
    ) -> tuple[str, str, float]:
        """The message, what is wanted and the points for the right value of which too few digits are left.

        Half the points, unless it may be a slip that was rounded.
        """
        digits = max(few.decimals + 1, decimals_for(quantity.tolerance(dealt.right[quantity.id])))
        wanted = f"au moins {digits} chiffre{'s' if digits > 1 else ''} après la virgule"
        doubtful = any(
            few.is_rounding_of(wrong) for name in quantity.slips for wrong in _slip_values(quantity, name, dealt, own)
        )
        message = f"{DOUBTFUL if doubtful else ROUNDED} : donnez {wanted}."
        return message, f"un nombre avec {wanted}", 0.0 if doubtful else PARTIAL_CREDIT * quantity.points

    def _find_slip(self, quantity: Quantity, value: float, dealt: NumericVariant, own: Values) -> str | None:
        """The slip that gives this value, from the right earlier values or from the student's own."""
        for name in quantity.slips:
            if any(quantity.is_within_tolerance(value, wrong) for wrong in _slip_values(quantity, name, dealt, own)):
                return name
        return None

    def _expected_interval_text(self, name: str, right: float, seed: int) -> str:
        """An interval without a sign, dealt once for a deal: trying again tells no more, nor does the seed alone."""
        low, high = rounded_bounds_around(abs(right), stream(seed, f"interval {name} {right:.6g}"))
        unit = next(question.unit for question in self.sheet.questions if question.id == name)
        return f"un nombre entre {number(low)} et {number(high)} {unit}".rstrip() + ", au signe près"

    def wrong_answers(self) -> Iterator[tuple[str, str | None, Callable[[int], Answers]]]:
        for name in self.catalogue:
            yield f"erreur {name}", name, partial(self.answers_with_mistake, name, follow=False)
            yield f"erreur {name}, la suite à l'avenant", name, partial(self.answers_with_mistake, name)
        yield "tout faux", None, lambda seed: {quantity.id: 1234.5 for quantity in self.quantities}

    def answers_with_mistake(self, name: str, seed: int, *, follow: bool = True) -> Answers:
        """The answers of someone who makes this mistake wherever it can be made; `follow`: and goes on from there."""
        dealt = _deal_variant(self, seed)
        own: dict[str, float] = {}
        for quantity in self.quantities:
            formula = quantity.slips.get(name, quantity.expected)
            own[quantity.id] = float(formula(dealt.data, own if follow else dealt.right))
        return own

    def transcribe(self, answers: Answers, seed: int) -> Sequence[AnswerTranscript]:
        def unit(question: NumericWording, value: Any) -> str:
            return question.unit if isinstance(_read_number_or_reason(value), float) else ""

        return [
            AnswerTranscript(question.id, question.title, f"{display_text(value)} {unit(question, value)}".rstrip())
            for question in self.sheet.questions
            if not is_blank(value := answers.get(question.id))
        ]

    def correction(self, seed: int) -> str:
        dealt = _deal_variant(self, seed)
        parts = []
        for index, (question, quantity) in enumerate(zip(self.sheet.questions, self.quantities, strict=True), 1):
            value = number(dealt.right[quantity.id], 4)
            parts.append(f"**{index}. {question.title}.** {self.sheet.fill_placeholders(question.text, dealt.data)}")
            if question.correction:
                parts.append(self.sheet.fill_placeholders(question.correction, {**dealt.data, **dealt.right}))
            parts.append(f"Réponse : **{value} {question.unit}**".rstrip("* ") + "**")
        return "\n\n".join(parts)

    def fill_with_sample_numbers(self, wording: str) -> str:
        dealt = _deal_variant(self, 0)
        return self.sheet.fill_placeholders(wording, {**dealt.data, **dealt.right})


@lru_cache(maxsize=512)
def _deal_variant(grader: NumericGrader, seed: int) -> NumericVariant:
    """The deal of a seed: the first for which no slip gives the right value, nor two slips the same, and nothing is 0.

    No interval of sizes holds zero: it would be guessed at once.
    """
    for try_number in range(MAX_DRAWS):
        dealt = _try_deal(grader, grader.draw_data(stream(seed, f"draw {try_number}")))
        if dealt is not None:
            return dealt
    raise MalformedExerciseError(
        grader.folder / MODULE_FILE,
        f"graine {seed} : dans tous les tirages, deux erreurs donnent le même nombre, ou la bonne réponse est nulle",
    )


def _try_deal(grader: NumericGrader, data: Data) -> NumericVariant | None:
    """None as soon as a question would not do: most deals fail early, and nine are made for one that is kept."""
    right: dict[str, float] = {}
    slips: dict[str, dict[str, float]] = {}
    for quantity in grader.quantities:
        slips[quantity.id] = {name: float(formula(data, right)) for name, formula in quantity.slips.items()}
        right[quantity.id] = float(quantity.expected(data, right))
        if not _are_well_separated(quantity, right[quantity.id], slips[quantity.id].values()):
            return None
    return NumericVariant(data, right, slips)


def _are_well_separated(quantity: Quantity, right: float, slips: Iterable[float]) -> bool:
    values = [right, *slips]
    if not all(map(math.isfinite, values)) or quantity.is_within_tolerance(values[0], 0.0, MIN_SEPARATION):
        return False
    pairs = ((value, other) for index, value in enumerate(values) for other in values[:index])
    return not any(
        quantity.is_within_tolerance(value, other, MIN_SEPARATION)
        or quantity.is_within_tolerance(other, value, MIN_SEPARATION)
        for value, other in pairs
    )


def _slip_values(quantity: Quantity, name: str, dealt: NumericVariant, own: Values) -> tuple[float, ...]:
    """Return the values of a slip, computed from the right earlier values and from the student's own."""
    followed = _evaluate_formula(quantity.slips[name], dealt.data, own)
    return (dealt.slips[quantity.id][name], *(() if followed is None else (followed,)))


def _evaluate_formula(formula: Formula, data: Data, own: Values) -> float | None:
    """Return a formula's value for a student's own finite values; None where it fails or is not finite."""
    try:
        with np.errstate(all="ignore"):
            value = float(formula(data, own))
    except (ArithmeticError, ValueError):
        return None
    return value if math.isfinite(value) else None


def _read_number_or_reason(raw: Any) -> float | str:
    """Return the number of an answer, or the reason why it is none."""
    try:
        if isinstance(raw, str):
            return read_number(raw)
        if isinstance(raw, bool) or not isinstance(raw, int | float):
            return "on attend un nombre"
        return check_finite(float(raw))
    except OverflowError:
        return "ce nombre est démesuré"
    except NotANumberError as error:
        return str(error)


def _wrong_value_message(quantity: Quantity, value: float, right: float) -> str:
    if quantity.is_within_tolerance(-value, right):
        return "Au signe près, c'est la bonne valeur."
    if quantity.is_within_tolerance(value, right, NEARLY_RIGHT):
        return "Vous êtes tout près : gardez plus de chiffres dans vos calculs, et n'arrondissez qu'à la fin."
    return "Ce n'est pas la bonne valeur."
