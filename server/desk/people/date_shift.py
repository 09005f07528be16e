"""By how much the dates of a class's assignments move in its copy for next year."""

from __future__ import annotations

import math
from datetime import date

from sqlalchemy.orm import Session

from server.assignments import repository
from server.base import school_time
from server.base.errors import Invalid
from server.classes.models import SchoolClass

WEEK = 7
MAX_WEEKS = 520
DEFAULT_WEEKS = "52"  # whole weeks, so that a Monday stays one
NOT_WEEKS = "Le décalage est un nombre entier de semaines, 520 au plus : 52 pour un an."
NOT_A_DATE = "« {text} » n’est pas une date, comme 2026-09-01."
TOO_FAR = "Cette date est à plus de dix ans de la première ouverture."


def shift_in_days(db: Session, original: SchoolClass, weeks: str, first_day: str) -> int:
    """From a number of weeks (a year's where nothing is said); or so that the first assignment opens from that day on.

    Always whole weeks, so that each date stays on its weekday. Raises Invalid.
    """
    if not first_day.strip():
        return WEEK * _parse_weeks(weeks.strip() or DEFAULT_WEEKS)
    try:
        wanted = date.fromisoformat(first_day.strip())
    except ValueError as error:
        raise Invalid(NOT_A_DATE.format(text=first_day.strip()[:40])) from error
    rows = repository.load_class_assignments(db, original.id)
    if not rows:
        return 0
    moved = WEEK * math.ceil((wanted - school_time.to_local(rows[0].opens_at).date()).days / WEEK)
    if abs(moved) > WEEK * MAX_WEEKS:
        raise Invalid(TOO_FAR)
    return moved


def _parse_weeks(text: str) -> int:
    sign = -1 if text.startswith(("-", "−")) else 1
    digits = text.lstrip("-−+")
    if not (digits.isascii() and digits.isdigit()) or len(digits) > 4 or int(digits) > MAX_WEEKS:
        raise Invalid(NOT_WEEKS)
    return sign * int(digits)
