"""The values of each rule for one student: the assignment's, those of exemptions, and which is in force. Pure."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, Literal, Protocol
from uuid import UUID

Field = Literal["opens_at", "due_at", "closes_at", "time_factor", "excused"]
Origin = Literal["assignment", "label", "student", "adjusted", "team"]


class CommonRules(Protocol):
    """The rules that an assignment sets for everyone. Where it has a `mode`, a test; see also `PastRules`."""

    @property
    def opens_at(self) -> datetime: ...
    @property
    def due_at(self) -> datetime | None: ...
    @property
    def closes_at(self) -> datetime | None: ...
    @property
    def late(self) -> str: ...
    @property
    def late_per_day(self) -> float | None: ...
    @property
    def duration_minutes(self) -> int | None: ...


class ExemptionFields(Protocol):
    """The rules that an exemption changes for a student or a label; None inherits.

    Optional: `extends`, whether its dates are never earlier than those of the others; `created_at`, from when it holds.
    """

    @property
    def account_id(self) -> UUID | None: ...
    @property
    def label(self) -> str | None: ...
    @property
    def opens_at(self) -> datetime | None: ...
    @property
    def due_at(self) -> datetime | None: ...
    @property
    def closes_at(self) -> datetime | None: ...
    @property
    def time_factor(self) -> float | None: ...
    @property
    def excused(self) -> bool | None: ...
    @property
    def revoked_at(self) -> datetime | None: ...


#: Chooses the value most favourable to a student among those of several labels.
MOST_FAVOURABLE: Mapping[Field, Callable[[Sequence[Any]], Any]] = {
    "opens_at": min,
    "due_at": max,
    "closes_at": max,
    "time_factor": max,
    "excused": max,
}
#: The dates that an exemption may extend: the opening of one's own day is another day, earlier or later.
EXTENDABLE: Collection[Field] = ("due_at", "closes_at")


@dataclass(frozen=True)
class SourcedValue:
    """A value of a field and its origin; `label` names the group; `adjusted` values are derived from other fields.

    `extends`: it does not count where another value of the field is later.
    """

    origin: Origin
    value: Any
    label: str = ""
    extends: bool = False


def sourced_values(name: Field, common: Any, exemptions: Sequence[ExemptionFields]) -> tuple[SourcedValue, ...]:
    """Return all values of a field, the one in force first."""
    given = [
        (value, exemption, name in EXTENDABLE and bool(getattr(exemption, "extends", False)))
        for exemption in exemptions
        if (value := getattr(exemption, name)) is not None
    ]
    values = []
    own = [(value, extends) for value, exemption, extends in given if exemption.account_id is not None]
    if own:
        best = MOST_FAVOURABLE[name]([value for value, _ in own])
        values.append(SourcedValue("student", best, extends=any(extends for value, extends in own if value == best)))
    labelled = [(value, exemption.label, extends) for value, exemption, extends in given if exemption.label is not None]
    if labelled:
        best = MOST_FAVOURABLE[name]([value for value, _, _ in labelled])
        ranked = sorted(labelled, key=lambda row: (row[0] != best, row[1]))
        values += [SourcedValue("label", value, label, extends) for value, label, extends in ranked]
    return _sort_in_force_first([*values, SourcedValue("assignment", common)])


def _sort_in_force_first(values: Sequence[SourcedValue]) -> tuple[SourcedValue, ...]:
    """Put the value in force first: one that extends gives way to a later date, and to none at all."""
    first, *others = values
    if not others:
        return (first,)
    best, *rest = _sort_in_force_first(others)
    if first.extends and (best.value is None or best.value > first.value):
        return (best, first, *rest)
    return (first, best, *rest)


def closing_dates_adjusted_for_extra_time(
    sources: Mapping[Field, tuple[SourcedValue, ...]], duration: timedelta | None, factor: float, *, is_test: bool
) -> tuple[SourcedValue, ...]:
    """Return the closing dates, with one late enough for extra time that was granted and for the due date.

    Extra time moves the closing by what it adds to the duration; to a test without a duration, its opening hours are
    its time. A later due date of one's own leaves the whole duration to who begins at the last moment.
    """
    closes, due = sources["closes_at"], sources["due_at"][0]
    end = closes[0].value
    if end is None:
        return closes
    length = (end - sources["opens_at"][0].value) if duration is None and is_test else duration
    if length is not None and factor > 1.0:
        end += max(length, timedelta()) * (factor - 1.0)
    if due.value is not None:
        end = max(end, due.value + _guaranteed_time_after_due(sources, duration, factor, is_test=is_test))
    return closes if end == closes[0].value else (SourcedValue("adjusted", end), *closes)


def _guaranteed_time_after_due(
    sources: Mapping[Field, tuple[SourcedValue, ...]], duration: timedelta | None, factor: float, *, is_test: bool
) -> timedelta:
    """Return the time that a due date of one's own leaves at least to who begins a test at that date."""
    common_due, common_closes = sources["due_at"][-1].value, sources["closes_at"][-1].value
    if not is_test or sources["due_at"][0].origin == "assignment":
        return timedelta()
    if duration is not None:
        return duration * factor
    return timedelta() if common_due is None or common_closes is None else max(timedelta(), common_closes - common_due)
