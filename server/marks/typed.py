"""Columns and marks as teachers type them: text to values and back, and what is refused. Pure."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date

from server.base.errors import Invalid, InvalidFields
from server.marks.means import format_number
from server.marks.models import COLUMN_TITLE_LENGTH, COMMENT_LENGTH
from server.marks.schemas import TypedMark
from server.marks.states import STATE_WORDS, MarkState, TypedState
from server.text.lines import normalise_line, require_normalised_line

MAX_SCALE = 1000.0
MAX_WEIGHT = 1000.0
ALLOWED_YEARS = range(2000, 2200)
HUNDREDTH_NOISE = 1e-6
NUMBER = r"[0-9]{1,9}(?:\.[0-9]{0,9})?"
WRITTEN_MARK = re.compile(rf"(?P<points>-?{NUMBER})(?:\s*/\s*(?P<scale>{NUMBER}))?")
MAX_TYPED = 40  # characters of a cell
#: The words that stand for a state, folded by `_fold_state_word`.
TYPED_WORDS: Mapping[str, TypedState] = {
    "abs": TypedState.absent,
    "absent": TypedState.absent,
    "absente": TypedState.absent,
    "disp": TypedState.excused,
    "dispense": TypedState.excused,
    "dispensee": TypedState.excused,
    "nr": TypedState.not_handed_in,
    "nonrendu": TypedState.not_handed_in,
}
NO_TITLE = f"Donnez à la colonne un titre de 1 à {COLUMN_TITLE_LENGTH} caractères."
NO_SCALE = "Le barème est un nombre plus grand que 0, jusqu’à 1000, avec deux décimales au plus."
NO_WEIGHT = "Le coefficient est un nombre de 0 à 1000 ; 0 : la colonne ne compte pas."
NO_DATE = "La date s’écrit avec le jour, le mois et l’année, de 2000 à 2199."
NO_MARK = "« {text} » n’est pas une note de 0 à {most}, ni « abs », « disp » ou « nr »."
OTHER_SCALE = "« {text} » : cette colonne est notée sur {most}."
TOO_MANY_POINTS = "« {text} » dépasse {most}."
NEGATIVE_POINTS = "« {text} » est plus petit que 0."
TOO_PRECISE = "« {text} » a plus de deux décimales : arrondissez."
LONG_COMMENT = f"La remarque tient en une ligne de {COMMENT_LENGTH} caractères."


@dataclass(frozen=True)
class ColumnInput:
    """The fields of a column that a teacher sets; see `models.ManualColumn`."""

    title: str
    out_of: float = 20.0
    taken_on: date | None = None
    weight: float = 1.0
    bonus: bool = False


def validate_column_fields(fields: ColumnInput) -> ColumnInput:
    """Return the input with its title tidied. Raise InvalidFields with every problem at once."""
    problems = {}
    title = fields.title
    try:
        title = require_normalised_line(fields.title, COLUMN_TITLE_LENGTH, NO_TITLE)
    except Invalid as refused:
        problems["title"] = refused.detail
    if not (0 < fields.out_of <= MAX_SCALE and _has_two_decimals(fields.out_of)):
        problems["out_of"] = NO_SCALE
    if not 0 <= fields.weight <= MAX_WEIGHT:
        problems["weight"] = NO_WEIGHT
    if fields.taken_on is not None and fields.taken_on.year not in ALLOWED_YEARS:
        problems["taken_on"] = NO_DATE
    if problems:
        raise InvalidFields(problems)
    return ColumnInput(title, fields.out_of, fields.taken_on, fields.weight, fields.bonus)


def _has_two_decimals(value: float) -> bool:
    return math.isfinite(value) and abs(100 * value - round(100 * value)) <= HUNDREDTH_NOISE


def parse_typed_mark(text: str, out_of: float) -> TypedMark:
    """Parse a cell: « 12,5 », « 12,5/20 » where the scale is that of the column, a state, or nothing. Raise Invalid."""
    folded = _fold_state_word(text)
    if not folded:
        return TypedMark()
    if folded in TYPED_WORDS:
        return TypedMark(state=TYPED_WORDS[folded])
    written = WRITTEN_MARK.fullmatch(text.replace(",", ".").strip())
    if written is None:
        raise _refuse_typed_mark(NO_MARK, text, out_of)
    if written["scale"] is not None and float(written["scale"]) != out_of:
        raise _refuse_typed_mark(OTHER_SCALE, text, out_of)
    return TypedMark(points=require_points_on_scale(float(written["points"]), out_of, text))


def require_points_on_scale(points: float, out_of: float, text: str = "") -> float:
    """Return points that the scale allows. Raise Invalid."""
    text = text or format_number(points)
    if not math.isfinite(points):
        raise _refuse_typed_mark(NO_MARK, text, out_of)
    if points < 0 or points > out_of:
        raise _refuse_typed_mark(NEGATIVE_POINTS if points < 0 else TOO_MANY_POINTS, text, out_of)
    if not _has_two_decimals(points):
        raise _refuse_typed_mark(TOO_PRECISE, text, out_of)
    return points + 0.0  # turns a negative zero into a zero


def _refuse_typed_mark(sentence: str, text: str, out_of: float) -> Invalid:
    return Invalid(sentence.format(text=normalise_line(text)[:MAX_TYPED], most=format_number(out_of)))


def _fold_state_word(text: str) -> str:
    return re.sub(r"[\s.()]", "", normalise_line(text).casefold().replace("é", "e"))


def format_typed_mark(mark: TypedMark) -> str:
    """Return the text of a cell, which `parse_typed_mark` reads again."""
    if mark.points is not None:
        return format_number(mark.points)
    return "" if mark.state is None else STATE_WORDS[MarkState(mark.state.value)]


def parse_mark_comment(text: str) -> str:
    """Return a comment in one line. Raise Invalid for one that is too long or cannot be written."""
    return require_normalised_line(text, COMMENT_LENGTH, LONG_COMMENT) if normalise_line(text) else ""
