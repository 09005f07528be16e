"""The one model of time: from an assignment, its exemptions, a sitting and the school's clock to every date and mark.

`rules_in_force` gives the rules for a student; `SendingWindow` adds their sitting. All pages, refusals and marks ask
here: nothing else computes dates. Pure functions; times are aware, and compared as instants. A date belongs to the
time that it ends: an attempt that arrives at the due date is on time. A sitting alone is over at its end.

Field by field, a student's own exemption takes precedence over those of their labels, and the most favourable of
several labels wins; the assignment gives the rest. An exemption that extended a date never leaves less than the others
have: the later date is in force.

What was told stays true. An attempt is judged by the rules in force when it arrived or by today's, whichever is more
favourable; a sitting ends no earlier than at any end that was told while it ran.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from datetime import datetime, timedelta, tzinfo
from enum import StrEnum
from typing import Protocol
from uuid import UUID

from server.assignments.models import EndedBy, LatePolicy, Mode, PastRules
from server.assignments.rule_sources import (
    CommonRules,
    ExemptionFields,
    Field,
    SourcedValue,
    closing_dates_adjusted_for_extra_time,
    sourced_values,
)
from server.base import school_time

DAY = timedelta(days=1)
MAX_POINTS = 20.0


class SittingTimes(Protocol):
    """When a sitting began, and when and by whom it was ended."""

    @property
    def began_at(self) -> datetime: ...
    @property
    def handed_in_at(self) -> datetime | None: ...
    @property
    def ended_by(self) -> str | None: ...


class TimingKind(StrEnum):
    """How an attempt stands to the dates; the last three do not count. `outside`: of a test, outside its sitting."""

    on_time = "on_time"
    late = "late"
    refused_late = "refused_late"
    closed = "closed"
    outside = "outside"


@dataclass(frozen=True)
class SendTiming:
    """How an attempt stands to the dates: days late begun on the school's clock, and the points out of 20 they cost.

    `counted_on_arrival`: whether it counted by the rules in force when it arrived.
    """

    kind: TimingKind
    days_late: int = 0
    penalty: float = 0.0
    counted_on_arrival: bool = True

    @property
    def counts(self) -> bool:
        return self.kind in {TimingKind.on_time, TimingKind.late}

    def apply_late_penalty(self, points: float) -> LateAdjustedPoints:
        """Return what is left of these points out of 20."""
        return LateAdjustedPoints(max(0.0, points - self.penalty), self.days_late) if self.counts else NOT_COUNTED

    @property
    def favour_sort_key(self) -> tuple[bool, float, int]:
        """Sorts the more favourable last."""
        return self.counts, -self.penalty, -self.days_late


@dataclass(frozen=True)
class LateAdjustedPoints:
    """Points out of 20 after any late penalty, None where the attempt does not count; days late begun."""

    points: float | None
    days_late: int = 0


NOT_COUNTED = LateAdjustedPoints(None)
OUTSIDE, ON_TIME = SendTiming(TimingKind.outside), SendTiming(TimingKind.on_time)


@dataclass(frozen=True)
class Rules:
    """The rules in force for one student; `sources` lists the values of each field, the one in force first.

    In a test, the due date is when it is begun at the latest to be on time; a sitting begun in time counts to its own
    end. `earlier`: the rules that were in force before. `is_concerned`: the assignment is for the whole class, or
    for a group of the student. `shared`: the rules of those with whom the student hands in, or handed in.
    """

    opens_at: datetime
    due_at: datetime | None
    closes_at: datetime | None
    late: LatePolicy
    late_per_day: float
    time_factor: float
    excused: bool
    duration: timedelta | None
    sources: Mapping[Field, tuple[SourcedValue, ...]]
    is_test: bool = False
    zone: tzinfo = field(default_factory=school_time.time_zone)
    earlier: tuple[EarlierRules, ...] = ()
    is_concerned: bool = True
    shared: tuple[TeammateRules, ...] = ()

    @property
    def is_exempt(self) -> bool:
        """Whether nothing is asked of the student, who is excused or in none of the groups."""
        return self.excused or not self.is_concerned

    def latest_sitting_end(self, began: datetime) -> datetime | None:
        """Return when a test begun at that time ends: no earlier than any end that was told since.

        One that had no end for a time does not end before that time.
        """
        end = self._own_sitting_end(began)
        if end is None:
            return None
        told = [past.rules._own_sitting_end(began) or past.until for past in self.earlier if past.until > began]
        return max([end, *told])

    def _own_sitting_end(self, began: datetime) -> datetime | None:
        end = None if self.duration is None else began + self.duration
        return min((each for each in (self.closes_at, end) if each is not None), default=None)

    def can_begin_at(self, at: datetime) -> bool:
        """Whether a test may be begun then: it is open, and not past a due date after which it is refused."""
        if at < self.opens_at or (self.closes_at is not None and at >= self.closes_at):
            return False
        return self.late is not LatePolicy.refuse or self.due_at is None or at <= self.due_at

    @property
    def without_earlier_rules(self) -> Rules:
        """The rules in force, without those before them."""
        return replace(self, earlier=())

    def judge_timing(self, at: datetime) -> SendTiming:
        """Return how an attempt that arrived at that time, or a test that was begun then, stands to the dates.

        An attempt that arrived before the opening is on time: exercises may be done before they are assigned.
        """
        now = self._judge_by_own_dates(at)
        if not self.earlier and not self.shared:
            return now
        then = next((past.rules._judge_by_own_dates(at) for past in self.earlier if past.since <= at < past.until), now)
        team = [each.rules.judge_timing(at) for each in self.shared if each.covers(at)]
        best = max(now, then, *team, key=lambda timing: timing.favour_sort_key)
        counted = then.counts or any(timing.counts and timing.counted_on_arrival for timing in team)
        return replace(best, counted_on_arrival=counted or not best.counts)

    def _judge_by_own_dates(self, at: datetime) -> SendTiming:
        if at >= self.opens_at and self.closes_at is not None and at > self.closes_at:
            return SendTiming(TimingKind.closed)
        days = self.count_days_late(at)
        if not days or at < self.opens_at:
            return ON_TIME
        if self.late is LatePolicy.refuse:
            return SendTiming(TimingKind.refused_late, days)
        return SendTiming(TimingKind.late, days, days * self.late_per_day if self.late is LatePolicy.penalty else 0.0)

    def count_days_late(self, at: datetime) -> int:
        """Return the days begun since the due date, on the school's clock."""
        return 0 if self.due_at is None else school_time.count_days_begun(self.due_at, at, self.zone)

    @property
    def latest_counting_time(self) -> datetime | None:
        """Until when an attempt counts; for a test, until when it may be begun."""
        ends = [self.closes_at] if self.late is not LatePolicy.refuse else [self.closes_at, self.due_at]
        return min((end for end in ends if end is not None), default=None)


@dataclass(frozen=True)
class EarlierRules:
    """The rules that were in force for a student from one time to another, excluded."""

    since: datetime
    until: datetime
    rules: Rules


@dataclass(frozen=True)
class TeammateRules:
    """The rules of a member of the student's team, while both are in it; `until` is None for a team of today."""

    since: datetime
    until: datetime | None
    rules: Rules

    def covers(self, at: datetime) -> bool:
        return self.since <= at and (self.until is None or at < self.until)


@dataclass(frozen=True)
class SendingWindow:
    """The rules in force for a student and their sitting: when they may send, what counts, and how late it is."""

    rules: Rules
    sitting: SittingTimes | None = None

    @property
    def ends_at(self) -> datetime | None:
        """The end that the student is told: of their sitting, or of the last time to begin or to send."""
        return self.rules.latest_counting_time if self.sitting is None else sitting_end(self.rules, self.sitting)

    @property
    def concerns_student(self) -> bool:
        """Whether the assignment is given to the student, or they sat it before they left its groups."""
        return self.rules.is_concerned or self.sitting is not None

    def judge_timing(self, sent_at: datetime) -> SendTiming:
        """Return how an attempt stands to the dates. In a test, whatever is sent in one sitting is as late as it began.

        Attempts outside the sitting may lie between the test's dates: those of a guest who later signed in. Of students
        whom the assignment does not concern, only what they sent in a sitting counts.
        """
        if not self.concerns_student:
            return OUTSIDE
        if not self.rules.is_test:
            return self.rules.judge_timing(sent_at)
        if self.sitting is None or sent_at < self.sitting.began_at:
            return OUTSIDE
        end = self.sitting.handed_in_at or sitting_end(self.rules, self.sitting)
        if end is not None and sent_at > end:
            return OUTSIDE
        timing = self.rules.judge_timing(self.sitting.began_at)
        # It was allowed to begin, and its page told no refusal.
        return timing if timing.counts else SendTiming(TimingKind.late, timing.days_late)


def is_sitting_running(rules: Rules, sitting: SittingTimes, now: datetime) -> bool:
    """Whether a sitting is neither handed in nor past its end."""
    if sitting.ended_by == EndedBy.student:
        return False
    end = rules.latest_sitting_end(sitting.began_at)
    return end is None or now < end


def sitting_end(rules: Rules, sitting: SittingTimes) -> datetime | None:
    """Return when a sitting has ended, or will; None where only its student ends it."""
    if sitting.ended_by == EndedBy.student:
        return sitting.handed_in_at
    return rules.latest_sitting_end(sitting.began_at)


def rules_in_force(
    common: CommonRules,
    exemptions: Collection[ExemptionFields],
    student: UUID,
    labels: Collection[str],
    *,
    zone: tzinfo | None = None,
) -> Rules:
    """Return the rules for a student who has these labels, on the school's clock (`zone`, else the server's).

    Exemptions of others are ignored; revoked ones were in force until they were revoked, and so were the assignment's
    `past_rules`.
    """
    own = [each for each in exemptions if _exemption_applies_to(each, student, labels)]
    zone = zone or school_time.time_zone()
    is_test = getattr(common, "mode", Mode.practice) == Mode.test
    active = [each for each in own if each.revoked_at is None]
    rules = _combine_with_exemptions(common, active, is_test=is_test, zone=zone)
    earlier = tuple(_iter_earlier_rules(common, own, is_test=is_test, zone=zone))
    rules = replace(rules, earlier=earlier) if earlier else rules
    return rules if is_assigned_to(common, labels) else replace(rules, is_concerned=False)


def is_assigned_to(common: CommonRules, labels: Collection[str]) -> bool:
    """Return whether an assignment is given to a student who has these labels."""
    groups: Sequence[str] = getattr(common, "groups", None) or ()
    return not groups or any(label in groups for label in labels)


def _exemption_applies_to(exemption: ExemptionFields, student: UUID, labels: Collection[str]) -> bool:
    return exemption.account_id == student or exemption.label in labels


def _iter_earlier_rules(
    common: CommonRules, own: Sequence[ExemptionFields], *, is_test: bool, zone: tzinfo
) -> Iterator[EarlierRules]:
    """Yield the rules that were in force before, oldest first, from when the assignment was made."""
    past: Sequence[PastRules] = getattr(common, "past_rules", None) or ()
    made: datetime | None = getattr(common, "created_at", None)
    if made is None or not (past or own):
        return
    spans = [(each, *_exemption_period(each)) for each in own]
    changes = {each.until for each in past} | {time for _, *span in spans for time in span if time is not None}
    since = made
    for until in sorted(change for change in changes if change > made):
        then = next((each for each in past if since < each.until), common)
        active = [each for each, start, end in spans if (start is None or start <= since) and (not end or since < end)]
        yield EarlierRules(since, until, _combine_with_exemptions(then, active, is_test=is_test, zone=zone))
        since = until


def _exemption_period(exemption: ExemptionFields) -> tuple[datetime | None, datetime | None]:
    return getattr(exemption, "created_at", None), exemption.revoked_at


def _combine_with_exemptions(
    common: CommonRules, own: Sequence[ExemptionFields], *, is_test: bool, zone: tzinfo
) -> Rules:
    """Return the rules from those for everyone and the exemptions of one student."""
    sources: dict[Field, tuple[SourcedValue, ...]] = {
        "opens_at": sourced_values("opens_at", common.opens_at, own),
        "due_at": sourced_values("due_at", common.due_at, own),
        "closes_at": sourced_values("closes_at", common.closes_at, own),
        "time_factor": sourced_values("time_factor", 1.0, own),
        "excused": sourced_values("excused", False, own),
    }
    factor = float(sources["time_factor"][0].value)
    minutes = common.duration_minutes
    duration = None if minutes is None else timedelta(minutes=minutes)
    sources["closes_at"] = closing_dates_adjusted_for_extra_time(sources, duration, factor, is_test=is_test)
    return Rules(
        opens_at=sources["opens_at"][0].value,
        due_at=sources["due_at"][0].value,
        closes_at=sources["closes_at"][0].value,
        late=LatePolicy(common.late),
        late_per_day=common.late_per_day or 0.0,
        time_factor=factor,
        excused=bool(sources["excused"][0].value),
        duration=None if duration is None else duration * factor,
        sources=sources,
        is_test=is_test,
        zone=zone,
    )
