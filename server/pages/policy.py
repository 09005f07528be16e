"""Describes a resource policy in French."""

from __future__ import annotations

from collections.abc import Callable

from server.base.validation import NO_BREAK, format_size
from server.course import Exercise
from server.sandbox.policy import LIMIT_SPECS, Unit
from server.web.words import format_points

_THIN = "\u202f"


def _seconds(value: float) -> str:
    return f"{format_points(value)}{NO_BREAK}s"


def _count(value: float) -> str:
    """1 500, with the thin space of French thousands."""
    return f"{value:,.0f}".replace(",", _THIN)


def _threads(value: float) -> str:
    return "un seul" if value == 1 else _count(value)


READ: dict[Unit, Callable[[float], str]] = {
    "seconds": _seconds,
    "bytes": format_size,
    "count": _count,
    "levels": lambda value: f"{_count(value)}{NO_BREAK}niveaux",
    "threads": _threads,
}


def policy_lines(exercise: Exercise) -> tuple[tuple[str, str], ...]:
    """Name and value of each limit of the policy, for this exercise."""
    return tuple((row.label, READ[row.unit](getattr(exercise.policy, name))) for name, row in LIMIT_SPECS.items())
