"""The rules in force for a student, computed from an assignment and its exemptions. Pure functions.

Field by field, a student's own exemption takes precedence over those of their labels, and the most favourable of
several labels wins; the assignment gives the rest. Times are aware, and compared as instants without a time zone.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Any, Literal, Protocol
from uuid import UUID

from server.assignments.models import LatePolicy

Field = Literal["opens_at", "due_at", "closes_at", "time_factor", "excused"]
Origin = Literal["assignment", "label", "student", "adjusted"]
DAY = timedelta(days=1)
MAX_POINTS = 20.0


class CommonRules(Protocol):
    """The rules that an assignment sets for everyone."""

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
    """The rules that an exemption changes for a student or a label; None inherits."""

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


@dataclass(frozen=True)
class SourcedValue:
    """A value of a field and its origin; `label` names the group; `adjusted` values are derived from other fields."""

    origin: Origin
    value: Any
    label: str = ""


@dataclass(frozen=True)
class Rules:
    """The rules in force for one student; `sources` lists the values of each field, the one in force first."""

    opens_at: datetime
    due_at: datetime | None
    closes_at: datetime | None
    late: LatePolicy
    late_per_day: float
    time_factor: float
    excused: bool
    duration: timedelta | None
    sources: Mapping[Field, tuple[SourcedValue, ...]]

    def end_of_sitting(self, began: datetime) -> datetime | None:
        """Return when a test begun at that time ends."""
        own_end = None if self.duration is None else began + self.duration
        return min((end for end in (self.closes_at, own_end) if end is not None), default=None)

    def apply_lateness(self, sent_at: datetime, points: float) -> LateAdjustedPoints:
        """Return the points out of 20 that an attempt sent at that time keeps.

        An attempt sent before the opening is on time: exercises may be done before they are assigned. Attempts at a
        test are first filtered by `counting.attempts_in_sitting`.
        """
        if self.closes_at is not None and sent_at > self.closes_at:
            return NOT_COUNTED
        if self.due_at is None or sent_at <= self.due_at:
            return LateAdjustedPoints(points)
        if self.late is LatePolicy.refuse:
            return NOT_COUNTED
        days = math.ceil((sent_at - self.due_at) / DAY)
        lost = days * self.late_per_day if self.late is LatePolicy.penalty else 0.0
        return LateAdjustedPoints(max(0.0, points - lost), days)

    @property
    def last_counted_at(self) -> datetime | None:
        """Until when an attempt counts."""
        ends = [self.closes_at] if self.late is not LatePolicy.refuse else [self.closes_at, self.due_at]
        return min((end for end in ends if end is not None), default=None)


@dataclass(frozen=True)
class LateAdjustedPoints:
    """Points out of 20 after any late penalty, None where the attempt does not count; days late, rounded up."""

    points: float | None
    days_late: int = 0


NOT_COUNTED = LateAdjustedPoints(None)


def rules_in_force(
    common: CommonRules, exemptions: Collection[ExemptionFields], student: UUID, labels: Collection[str]
) -> Rules:
    """Return the rules for a student who has these labels. Revoked exemptions and those of others are ignored."""
    own = [each for each in exemptions if each.revoked_at is None and _applies_to(each, student, labels)]
    sources: dict[Field, tuple[SourcedValue, ...]] = {
        "opens_at": _sourced_values("opens_at", common.opens_at, own),
        "due_at": _sourced_values("due_at", common.due_at, own),
        "closes_at": _sourced_values("closes_at", common.closes_at, own),
        "time_factor": _sourced_values("time_factor", 1.0, own),
        "excused": _sourced_values("excused", False, own),
    }
    factor = float(sources["time_factor"][0].value)
    minutes = common.duration_minutes
    duration = None if minutes is None else timedelta(minutes=minutes) * factor
    sources["closes_at"] = _adjusted_closing(sources, None if minutes is None else timedelta(minutes=minutes), factor)
    return Rules(
        opens_at=sources["opens_at"][0].value,
        due_at=sources["due_at"][0].value,
        closes_at=sources["closes_at"][0].value,
        late=LatePolicy(common.late),
        late_per_day=common.late_per_day or 0.0,
        time_factor=factor,
        excused=bool(sources["excused"][0].value),
        duration=duration,
        sources=sources,
    )


def _applies_to(exemption: ExemptionFields, student: UUID, labels: Collection[str]) -> bool:
    return exemption.account_id == student or exemption.label in labels


def _sourced_values(field: Field, common: Any, exemptions: Sequence[ExemptionFields]) -> tuple[SourcedValue, ...]:
    """Return all values of a field, the one in force first."""
    given = [(value, exemption) for exemption in exemptions if (value := getattr(exemption, field)) is not None]
    own = [value for value, exemption in given if exemption.account_id is not None]
    labelled = [(value, exemption.label) for value, exemption in given if exemption.label is not None]
    values = [SourcedValue("student", MOST_FAVOURABLE[field](own))] if own else []
    if labelled:
        best = MOST_FAVOURABLE[field]([value for value, _ in labelled])
        ranked = sorted(labelled, key=lambda pair: (pair[0] != best, pair[1]))
        values += [SourcedValue("label", value, label) for value, label in ranked]
    return (*values, SourcedValue("assignment", common))


def _adjusted_closing(
    sources: Mapping[Field, tuple[SourcedValue, ...]], duration: timedelta | None, factor: float
) -> tuple[SourcedValue, ...]:
    """Return the closing dates, with one late enough for extra time that was granted and for the due date."""
    closes, due = sources["closes_at"], sources["due_at"][0].value
    end = closes[0].value
    if end is None:
        return closes
    if duration is not None and factor > 1.0:
        end += duration * (factor - 1.0)
    if due is not None:
        end = max(end, due)
    return closes if end == closes[0].value else (SourcedValue("adjusted", end), *closes)
