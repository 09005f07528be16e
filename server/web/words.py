"""Marks, counts and dates in French words."""

from __future__ import annotations

import math
from datetime import UTC, datetime

from graders.core.compare.words import number

WHOLE = 1e-9  # points that rounding may take from a full mark


def points(value: float) -> str:
    """A mark in French, at most two decimals: 12,5."""
    return number(round(float(value), 2), 4)


def mark(value: float, most: float = 20.0) -> str:
    """What was obtained of `most` points, to the nearest quarter: 2,75. Less than all of them is never shown as all.

    Marks are kept and summed exactly: only what is read is rounded, here and nowhere else.
    """
    if value >= most - WHOLE:
        return points(most)
    nearest, below = math.floor(4 * value + 0.5), math.ceil(4 * most - WHOLE) - 1
    return points(min(nearest, below) / 4)


def plural(count: int, singular: str, many: str | None = None) -> str:
    """« 1 essai », « 3 essais »: zero and one take the singular, as in French."""
    return f"{count} {singular if abs(count) < 2 else many or singular + 's'}"


def moment(when: datetime) -> str:
    """A date as ISO text for a `<time>` element: the browser's script shows it in local time."""
    aware = when if when.tzinfo else when.replace(tzinfo=UTC)
    return aware.astimezone(UTC).isoformat(timespec="seconds")


def moment_text(when: datetime) -> str:
    """The same date for a reader without script: « 21/11/2026 à 12:05 (UTC) »."""
    aware = when if when.tzinfo else when.replace(tzinfo=UTC)
    return aware.astimezone(UTC).strftime("%d/%m/%Y à %H:%M (UTC)")
