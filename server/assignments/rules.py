"""The rules in force for a student: pure, from an assignment and what differs for some.

A student's own exemption comes before those of their labels, field by field; of several labels the most favourable
holds; what none says is as the assignment has it. Times are aware, compared as instants: no time zone comes in.
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
    """What an assignment says of everyone."""

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
    """What an exemption says of some."""

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


#: What is most favourable to a student, of the values of several labels.
BEST: Mapping[Field, Callable[[Sequence[Any]], Any]] = {
    "opens_at": min,
    "due_at": max,
    "closes_at": max,
    "time_factor": max,
    "excused": max,
}


@dataclass(frozen=True)
class SourcedValue:
    """One value that was said of a field, and by whom: `label` names the group; `adjusted`: follows from another."""

    origin: Origin
    value: Any
    label: str = ""


@dataclass(frozen=True)
class Rules:
    """The rules in force for one student; `why` says of each field what was said of it, what holds first."""

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
        """When a test ends for who began it then."""
        own_end = None if self.duration is None else began + self.duration
        return min((end for end in (self.closes_at, own_end) if end is not None), default=None)

    def apply_lateness(self, sent_at: datetime, points: float) -> LateAdjustedPoints:
        """What an attempt of so many points out of 20, sent then, comes to.

        Who has worked ahead is on time: exercises may be done before somebody assigns them. Of a test only what is sent
        while one sits it is asked about (`counting.in_sitting`).
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
        """Until when something may be sent that counts."""
        ends = [self.closes_at] if self.late is not LatePolicy.refuse else [self.closes_at, self.due_at]
        return min((end for end in ends if end is not None), default=None)


@dataclass(frozen=True)
class LateAdjustedPoints:
    """Points out of 20 once lateness has taken its share, None for what does not count; days late, begun ones whole."""

    points: float | None
    days_late: int = 0


NOT_COUNTED = LateAdjustedPoints(None)


def rules_in_force(
    frame: CommonRules, differences: Collection[ExemptionFields], student: UUID, labels: Collection[str]
) -> Rules:
    """The rules for a student who has these labels. Revoked exemptions and those of others are left out."""
    mine = [one for one in differences if one.revoked_at is None and _is_of(one, student, labels)]
    why: dict[Field, tuple[SourcedValue, ...]] = {
        "opens_at": _said("opens_at", frame.opens_at, mine),
        "due_at": _said("due_at", frame.due_at, mine),
        "closes_at": _said("closes_at", frame.closes_at, mine),
        "time_factor": _said("time_factor", 1.0, mine),
        "excused": _said("excused", False, mine),
    }
    factor = float(why["time_factor"][0].value)
    minutes = frame.duration_minutes
    duration = None if minutes is None else timedelta(minutes=minutes) * factor
    why["closes_at"] = _adjusted(why, None if minutes is None else timedelta(minutes=minutes), factor)
    return Rules(
        opens_at=why["opens_at"][0].value,
        due_at=why["due_at"][0].value,
        closes_at=why["closes_at"][0].value,
        late=LatePolicy(frame.late),
        late_per_day=frame.late_per_day or 0.0,
        time_factor=factor,
        excused=bool(why["excused"][0].value),
        duration=duration,
        sources=why,
    )


def _is_of(one: ExemptionFields, student: UUID, labels: Collection[str]) -> bool:
    return one.account_id == student or one.label in labels


def _said(field: Field, common: Any, mine: Sequence[ExemptionFields]) -> tuple[SourcedValue, ...]:
    """What holds first, then what it goes before."""
    own = [value for one in mine if one.account_id is not None and (value := getattr(one, field)) is not None]
    labelled = [
        (value, one.label) for one in mine if one.label is not None and (value := getattr(one, field)) is not None
    ]
    said = [SourcedValue("student", BEST[field](own))] if own else []
    if labelled:
        best = BEST[field]([value for value, _ in labelled])
        first = sorted(labelled, key=lambda pair: (pair[0] != best, pair[1]))
        said += [SourcedValue("label", value, label) for value, label in first]
    return (*said, SourcedValue("assignment", common))


def _adjusted(
    why: Mapping[Field, tuple[SourcedValue, ...]], duration: timedelta | None, factor: float
) -> tuple[SourcedValue, ...]:
    """A closing never cuts off extra time that was granted, nor comes before the due date."""
    closes, due = why["closes_at"], why["due_at"][0].value
    end = closes[0].value
    if end is None:
        return closes
    if duration is not None and factor > 1.0:
        end += duration * (factor - 1.0)
    if due is not None:
        end = max(end, due)
    return closes if end == closes[0].value else (SourcedValue("adjusted", end), *closes)
