"""Marks, counts and dates in French words."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from datetime import UTC, date, datetime
from functools import lru_cache
from zoneinfo import ZoneInfo

from graders.core.compare.words import number
from server.base import school_time

DAYS = ("lundi", "mardi", "mercredi", "jeudi", "vendredi", "samedi", "dimanche")
MONTHS = (
    "janvier", "février", "mars", "avril", "mai", "juin",
    "juillet", "août", "septembre", "octobre", "novembre", "décembre",
)  # fmt: skip
#: Marks and times that were written lately: a list of attempts is read again with each of them.
KEPT = 4096
WHOLE = 1e-9  # points that rounding may take from a full mark


@lru_cache(maxsize=KEPT)
def format_points(value: float) -> str:
    """A mark in French, at most two decimals: 12,5."""
    return number(round(float(value), 2), 4)


@lru_cache(maxsize=KEPT)
def format_mark(value: float, most: float = 20.0) -> str:
    """What was obtained of `most` points, to the nearest quarter: 2,75. Less than all of them is never shown as all.

    Marks are kept and summed exactly: only what is read is rounded, here and nowhere else.
    """
    if value >= most - WHOLE:
        return format_points(most)
    nearest, below = math.floor(4 * value + 0.5), math.ceil(4 * most - WHOLE) - 1
    return format_points(min(nearest, below) / 4)


def count_with_noun(count: int, singular: str, many: str | None = None) -> str:
    """« 1 essai », « 3 essais »: zero and one take the singular, as in French."""
    return f"{count} {singular if abs(count) < 2 else many or singular + 's'}"


def join_names_with_limit(names: Sequence[str], limit: int = 6) -> str:
    """Return the names in one line, those beyond the limit as a number: « Ada, Inès et 3 autres »."""
    shown, others = (names, 0) if len(names) <= limit + 1 else (names[:limit], len(names) - limit)
    listed = ", ".join(shown)
    return f"{listed} et {others} autres" if others else listed


def join_words(words: Iterable[str]) -> str:
    """Join the items of a list: « lundi 23, mardi 24 et jeudi 26 »."""
    *before, last = words
    return f"{', '.join(before)} et {last}" if before else last


def format_iso_time(when: datetime) -> str:
    """A date as ISO text for a `<time>` element."""
    return _to_utc(when).isoformat(timespec="seconds")


def _to_utc(when: datetime) -> datetime:
    return (when if when.tzinfo else when.replace(tzinfo=UTC)).astimezone(UTC)


def format_short_time(when: datetime) -> str:
    """The same date on the school's clock, short, for a table: « 21/11/2026 à 12 h 05 »."""
    return _format_time_in_zone(_to_utc(when), school_time.time_zone())


@lru_cache(maxsize=KEPT)
def _format_time_in_zone(when: datetime, _zone: ZoneInfo) -> str:
    here = school_time.to_local(when)
    return f"{here:%d/%m/%Y} à {school_time.format_hour(here)}{_first_or_second_occurrence(when)}"


def format_long_time(when: datetime) -> str:
    """The same in a sentence: « lundi 23 mars 2026 à 18 h 00 »."""
    hour = school_time.format_hour(school_time.to_local(when))
    return f"{format_long_day(when)} à {hour}{_first_or_second_occurrence(when)}"


def format_long_day(when: datetime) -> str:
    """« lundi 23 mars 2026 », « dimanche 1er mars 2026 »."""
    here = school_time.to_local(when)
    return f"{format_short_day(here)} {MONTHS[here.month - 1]} {here.year}"


def format_short_day(day: date) -> str:
    """A day, or a moment on the school's clock, near to today: « lundi 23 », « dimanche 1er »."""
    return f"{DAYS[day.weekday()]} {'1er' if day.day == 1 else day.day}"


def _first_or_second_occurrence(when: datetime) -> str:
    """Which of both, of a time that comes twice in the night when the clock is put back."""
    if not school_time.is_ambiguous(when):
        return ""
    return " (heure d’été)" if school_time.to_local(when).dst() else " (heure d’hiver)"
