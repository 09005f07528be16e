"""Describes a resource policy in French."""

from __future__ import annotations

from collections.abc import Callable

from server.base.validation import NO_BREAK, format_size
from server.course import Exercise
from server.sandbox.policy import LIMIT_SPECS, Unit
from server.web.words import format_points

_THIN = "\u202f"


def _format_seconds(value: float) -> str:
    return f"{format_points(value)}{NO_BREAK}s"


def _format_count(value: float) -> str:
    """1 500, with the thin space of French thousands."""
    return f"{value:,.0f}".replace(",", _THIN)


def _format_threads(value: float) -> str:
    return "un seul" if value == 1 else _format_count(value)


READ: dict[Unit, Callable[[float], str]] = {
    "seconds": _format_seconds,
    "bytes": format_size,
    "count": _format_count,
    "levels": lambda value: f"{_format_count(value)}{NO_BREAK}niveaux",
    "threads": _format_threads,
}


def describe_policy_limits(exercise: Exercise) -> tuple[tuple[str, str], ...]:
    """Name and value of each limit of the policy, for this exercise."""
    return tuple((row.label, READ[row.unit](getattr(exercise.policy, name))) for name, row in LIMIT_SPECS.items())
