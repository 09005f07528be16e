"""Time: what a page tells before a send is what the mark says after it, whatever the rules become in between."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from datetime import UTC, datetime, timedelta, tzinfo
from typing import Any
from uuid import UUID
from zoneinfo import ZoneInfo

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from server.assignments.counting import ScoredAttempt, mark_attempts
from server.assignments.editing import append_past_rules
from server.assignments.exemption_service import never_moves_dates_earlier
from server.assignments.feedback import SittingStage, sitting_stage
from server.assignments.models import Assignment, AttemptSelection, EndedBy, Exemption, LatePolicy, Mode, Sitting
from server.assignments.rules import OUTSIDE, Rules, SendingWindow, SendTiming, TimingKind, rules_in_force, sitting_end
from server.assignments.schemas import AssignmentInput, ExemptionInput
from server.assignments.stages import AssignmentStage, assignment_stage
from server.base.school_time import count_days_begun, end_of_day

PARIS = ZoneInfo("Europe/Paris")
ZONES = ("Europe/Paris", "America/Martinique", "Pacific/Auckland", "America/St_Johns", "Africa/Casablanca", "UTC")
ADA = UUID(int=1)
EXAMPLES = 200
INSTANT, MINUTE, DAY = timedelta(microseconds=1), timedelta(minutes=1), timedelta(days=1)
#: Begins that a clock change follows within days, and a year's end.
STARTS = [datetime(*day, tzinfo=UTC) for day in ((2026, 10, 22), (2026, 3, 26), (2026, 12, 30), (2027, 6, 1))]


def paris(*time: int) -> datetime:
    return datetime(*time, tzinfo=PARIS).astimezone(UTC)  # type: ignore[misc]


DAYS = [
    ("an hour more than a day, in October", (2026, 10, 24, 18), (2026, 10, 25, 17, 59), 1),
    ("exactly a day later", (2026, 10, 24, 18), (2026, 10, 25, 18), 1),
    ("just before midnight", (2026, 10, 24, 23, 59), (2026, 10, 25, 23, 58), 1),
    ("a day and a minute", (2026, 10, 24, 18), (2026, 10, 25, 18, 1), 2),
    ("an hour less than a day, in March", (2026, 3, 28, 18), (2026, 3, 29, 18), 1),
    ("the second day begins, in March", (2026, 3, 28, 18), (2026, 3, 29, 18, 1), 2),
    ("a plain week", (2026, 10, 10, 18), (2026, 10, 17, 18), 7),
    ("over the year", (2026, 12, 31, 23), (2027, 1, 1, 23), 1),
    ("not late", (2026, 10, 24, 18), (2026, 10, 24, 18), 0),
    ("at a time that the clock skips", (2026, 3, 28, 2, 30), (2026, 3, 29, 3, 30), 1),
]


@pytest.mark.parametrize(("due", "sent", "days"), [row[1:] for row in DAYS], ids=[row[0] for row in DAYS])
def test_a_day_late_is_a_day_on_the_school_s_clock(due: tuple[int, ...], sent: tuple[int, ...], days: int) -> None:
    assert count_days_begun(paris(*due), paris(*sent), PARIS) == days
    rules = Rules(
        STARTS[1], paris(*due), None, LatePolicy.penalty, 2.0, 1.0, False, None, {}, zone=PARIS
    )  # fmt: skip
    assert rules.judge_timing(paris(*sent)).apply_late_penalty(20.0).points == 20 - 2 * days


def test_a_time_that_comes_twice_ends_the_day_when_it_comes_again() -> None:
    due = paris(2026, 10, 24, 2, 30)
    again = datetime(2026, 10, 25, 2, 30, tzinfo=PARIS, fold=1).astimezone(UTC)
    assert count_days_begun(due, again, PARIS) == 1
    assert count_days_begun(due, again + INSTANT, PARIS) == 2


instants = st.builds(
    lambda start, minutes, micro: start + timedelta(minutes=minutes, microseconds=micro),
    st.sampled_from(STARTS),
    st.integers(0, 14 * 24 * 60),
    st.integers(-1, 1),
)


@given(instants, st.integers(-60, 20 * 24 * 60), st.sampled_from(ZONES))
def test_days_are_counted_one_by_one(start: datetime, minutes: int, name: str) -> None:
    zone, at = ZoneInfo(name), start + timedelta(minutes=minutes)
    days = count_days_begun(start, at, zone)
    assert (days == 0) == (at <= start)
    if days:
        assert at <= end_of_day(start, days, zone)
        assert days == 1 or at > end_of_day(start, days - 1, zone)
        assert abs(at - start - days * DAY) <= DAY + timedelta(hours=2)


# --- A school: rules that change, exemptions, sittings, sends, each at its time


@dataclass
class School:
    """An assignment, and all that happens to it and to one student, without a database."""

    zone: tzinfo
    assignment: Assignment
    exemptions: list[Exemption] = field(default_factory=list)
    sitting: Sitting | None = None

    def rules(self) -> Rules:
        return rules_in_force(self.assignment, self.exemptions, ADA, ("TP1",), zone=self.zone)

    def change(self, now: datetime, values: dict[str, Any]) -> None:
        after = AssignmentInput("DM", (), **(self.times() | values))
        append_past_rules(self.assignment, after, now)
        for name, value in values.items():
            setattr(self.assignment, name, value)

    def times(self) -> dict[str, Any]:
        names = ("opens_at", "due_at", "closes_at", "late", "late_per_day", "duration_minutes")
        return {name: getattr(self.assignment, name) for name in names}

    def grant(self, now: datetime, values: dict[str, Any]) -> None:
        to = {"label": "TP1"} if values["label"] else {"account_id": ADA}
        fields = ExemptionInput(values["opens_at"], values["due_at"], values["closes_at"], values["time_factor"])
        extends = never_moves_dates_earlier(fields, self.assignment)
        self.exemptions.append(Exemption(created_at=now, extends=extends, **to, **fields.row_columns()))

    def revoke(self, now: datetime, number: int) -> None:
        active = [each for each in self.exemptions if each.revoked_at is None]
        if active:
            active[number % len(active)].revoked_at = now

    def begin(self, now: datetime) -> None:
        if self.stage(now) is SittingStage.may_begin:
            self.sitting = Sitting(began_at=now, handed_in_at=None, ended_by=None)

    def hand_in(self, now: datetime) -> None:
        if self.sitting is not None and self.stage(now) is SittingStage.running:
            self.sitting.handed_in_at, self.sitting.ended_by = now, EndedBy.student

    def collect(self, now: datetime) -> None:
        """As the collector of sittings does."""
        if self.sitting is not None and self.sitting.handed_in_at is None and self.stage(now) is SittingStage.over:
            self.sitting.handed_in_at = self.rules().latest_sitting_end(self.sitting.began_at)
            self.sitting.ended_by = EndedBy.time

    def stage(self, now: datetime) -> SittingStage:
        return sitting_stage(self.assignment, self.rules(), self.sitting, now)

    def tell(self, now: datetime) -> SendTiming | None:
        """What the pages tell of a send at this moment; None where it is refused."""
        rules = self.rules()
        if rules.is_test:
            if self.stage(now) is not SittingStage.running:
                return None
            assert self.sitting is not None
            if self.sitting.ended_by is not None:  # more time was granted: it goes on
                self.sitting.handed_in_at = self.sitting.ended_by = None
            timing = rules.judge_timing(self.sitting.began_at)
            return timing if timing.counts else SendTiming(TimingKind.late, timing.days_late)
        stage = assignment_stage(rules, now)
        if stage is AssignmentStage.closed:
            return OUTSIDE
        if stage is not AssignmentStage.late:
            return SendTiming(TimingKind.on_time)
        assert rules.due_at is not None
        days = 1
        while now > end_of_day(rules.due_at, days, self.zone):
            days += 1
        penalty = days * rules.late_per_day if rules.late is LatePolicy.penalty else 0.0
        return SendTiming(TimingKind.late, days, penalty)

    def judge_timing(self, sent_at: datetime) -> SendTiming:
        return SendingWindow(self.rules(), self.sitting).judge_timing(sent_at)


LENGTHS = (None, 1, 30, 55, 60, 90, 24 * 60, 3 * 24 * 60)
ACTIONS = ("change", "grant", "revoke", "begin", "begin", "hand_in", "collect", "send", "send", "send", "send")
Numbers = tuple[int, ...]
#: An event: what happens, when, and numbers that say the rest. Plain numbers are drawn ten times as fast as structures.
numbers = st.tuples(st.sampled_from(ACTIONS), *[st.integers(0, 20)] * 8)


def date(start: datetime, number: int, micro: int = 1) -> datetime:
    """Few, so that they meet: a multiple of half an hour, some of them days later, or an instant beside it."""
    steps = number if number < 14 else (number - 13) * 24
    return start + steps * 30 * MINUTE + (micro % 3 - 1) * INSTANT


def maybe_date(start: datetime, number: int) -> datetime | None:
    return None if number >= 18 else date(start, number)


def common_times(start: datetime, mode: Mode, row: Numbers) -> dict[str, Any]:
    opens = date(start, row[0] % 12)
    due, closes = maybe_date(start, row[1]), maybe_date(start, row[2])
    due = None if due is None else max(opens, due)
    late = list(LatePolicy)[row[3] % 3] if due else LatePolicy.accept
    return {
        "opens_at": opens,
        "due_at": due,
        "closes_at": None if closes is None else max(due or opens, closes),
        "late": late,
        "late_per_day": (0.5, 2.0, 20.0)[row[4] % 3] if late is LatePolicy.penalty else None,
        "duration_minutes": LENGTHS[row[5] % len(LENGTHS)] if mode is Mode.test else None,
    }


def exempted(start: datetime, row: Numbers) -> dict[str, Any]:
    dates = {
        name: maybe_date(start, each) for name, each in zip(("opens_at", "due_at", "closes_at"), row, strict=False)
    }
    return dates | {"time_factor": (None, 1.0, 1.33, 4.0)[row[3] % 4], "label": bool(row[4] % 2)}


@st.composite
def stories(draw: Callable[..., Any]) -> tuple[School, list[tuple[datetime, str, Any]]]:
    start, mode = draw(st.sampled_from(STARTS)), draw(st.sampled_from(Mode))
    _, *row = draw(numbers)
    zone = ZoneInfo(ZONES[row[6] % len(ZONES)])
    common = common_times(start, mode, tuple(row))
    school = School(zone, Assignment(mode=mode, created_at=start - DAY, past_rules=(), **common))
    events: list[tuple[datetime, str, Any]] = []
    for name, time, micro, *rest in draw(st.lists(numbers, min_size=1, max_size=10)):
        value: Any = None
        if name == "change":
            value = common_times(start, mode, tuple(rest))
        elif name == "grant":
            value = exempted(start, tuple(rest))
        elif name == "revoke":
            value = rest[0]
        events.append((date(start, time, micro), name, value))
    events.sort(key=lambda event: event[0])
    for number in range(1, len(events)):  # one after another
        now, *rest = events[number]
        events[number] = (max(now, events[number - 1][0] + INSTANT), *rest)
    return school, events


@settings(max_examples=EXAMPLES)
@given(stories())
def test_what_is_told_before_a_send_is_what_counts_after_it(
    story: tuple[School, list[tuple[datetime, str, Any]]],
) -> None:
    """Later changes make nothing worse. Before them, what is told and what counts are the same."""
    school, events = story
    promised: list[tuple[datetime, SendTiming]] = []
    told_end: datetime | None = None
    for now, name, value in events:
        if name == "send":
            told = school.tell(now)
            if told is not None:
                counted = school.judge_timing(now)
                assert counted.counts == told.counts
                assert not told.counts or (counted.days_late, counted.penalty) == (told.days_late, told.penalty)
                promised.append((now, counted))
                event(f"{school.assignment.mode}: {counted.kind}")
        else:
            getattr(school, name)(*(now, value) if value is not None else (now,))
        for sent_at, before in promised:
            assert school.judge_timing(sent_at).favour_sort_key >= before.favour_sort_key, (name, now)
        if school.sitting is not None and school.sitting.ended_by is None:
            end = sitting_end(school.rules(), school.sitting)
            assert told_end is None or end is None or end >= told_end, "no end comes earlier than it was told"
            told_end = end


@settings(max_examples=EXAMPLES)
@given(stories(), st.sampled_from([AttemptSelection.best, AttemptSelection.last]))
def test_changes_of_rules_leave_at_least_the_mark_that_was_told(
    story: tuple[School, list[tuple[datetime, str, Any]]], counts: AttemptSelection
) -> None:
    school, events = story
    sent: list[ScoredAttempt] = []
    told: list[float] = []
    for number, (now, name, value) in enumerate(events):
        if name != "send":
            getattr(school, name)(*(now, value) if value is not None else (now,))
        elif (timing := school.tell(now)) is not None:
            sent.append(ScoredAttempt(UUID(int=number), now, (number * 7 % 5) / 4))
            points = timing.apply_late_penalty(20 * sent[-1].score).points
            told += [] if points is None else [points]
        counted = mark_attempts(SendingWindow(school.rules(), school.sitting), counts, sent).counted
        if told:
            assert counted is not None
            assert counted.points >= (told[-1] if counts is AttemptSelection.last else max(told)), name
