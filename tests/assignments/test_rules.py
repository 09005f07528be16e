"""The rules in force for a student: who comes first, what is most favourable, what summer time changes (nothing)."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from uuid import UUID, uuid4
from zoneinfo import ZoneInfo

from hypothesis import given
from hypothesis import strategies as st

from server.assignments.rules import NOT_COUNTED, LateAdjustedPoints, rules_in_force

PARIS = ZoneInfo("Europe/Paris")
OPENS = datetime(2026, 3, 20, 8, tzinfo=UTC)
DAY = timedelta(days=1)
ADA, BOB = UUID(int=1), UUID(int=2)
LABELS = ("TP1", "TP2", "PAP")


@dataclass(frozen=True)
class Frame:
    opens_at: datetime = OPENS
    due_at: datetime | None = OPENS + 7 * DAY
    closes_at: datetime | None = OPENS + 10 * DAY
    late: str = "accept"
    late_per_day: float | None = None
    duration_minutes: int | None = None


@dataclass(frozen=True)
class Difference:
    account_id: UUID | None = None
    label: str | None = None
    opens_at: datetime | None = None
    due_at: datetime | None = None
    closes_at: datetime | None = None
    time_factor: float | None = None
    excused: bool | None = None
    revoked_at: datetime | None = None


moments = st.none() | st.integers(0, 40).map(lambda days: OPENS + days * DAY)
differences = st.lists(
    st.builds(
        Difference,
        *(st.just(None), st.sampled_from(LABELS), moments, moments, moments),
        st.none() | st.sampled_from([1.0, 1.33, 2.0]),
        st.none() | st.booleans(),
        st.none() | st.just(OPENS),
    ),
    max_size=5,
)


@given(differences, st.sets(st.sampled_from(LABELS)))
def test_of_several_labels_the_most_favourable_holds(told: list[Difference], labels: set[str]) -> None:
    rules = rules_in_force(Frame(), told, ADA, labels)
    mine = [one for one in told if one.label in labels and one.revoked_at is None]
    assert rules.opens_at == min([one.opens_at for one in mine if one.opens_at] or [OPENS])
    assert rules.due_at == max([one.due_at for one in mine if one.due_at] or [OPENS + 7 * DAY])
    assert rules.time_factor == max([one.time_factor for one in mine if one.time_factor] or [1.0])
    assert rules.excused == any(one.excused for one in mine)
    assert rules.closes_at is not None
    assert rules.due_at is not None
    assert rules.closes_at >= rules.due_at, "a due date is never after the end"
    assert rules.sources["due_at"][-1].origin == "assignment"


@given(differences, moments)
def test_a_students_own_date_comes_before_those_of_labels(told: list[Difference], due: datetime | None) -> None:
    own = Difference(account_id=ADA, due_at=due)
    rules = rules_in_force(Frame(), [*told, own], ADA, LABELS)
    without = rules_in_force(Frame(), told, ADA, LABELS)
    assert rules.due_at == (without.due_at if due is None else due)
    assert rules.opens_at == without.opens_at, "what a student's own says nothing of is inherited"
    assert rules_in_force(Frame(), [*told, own], BOB, LABELS) == rules_in_force(Frame(), told, BOB, LABELS)


@given(differences)
def test_who_has_no_label_has_the_assignments_own_rules(told: list[Difference]) -> None:
    assert rules_in_force(Frame(), told, ADA, ()) == rules_in_force(Frame(), [], ADA, ())


def test_a_penalty_is_for_each_day_begun_and_takes_no_more_than_all() -> None:
    due = OPENS + 2 * DAY
    second = timedelta(seconds=1)
    rules = rules_in_force(
        Frame(due_at=due, closes_at=due + 3 * DAY, late="penalty", late_per_day=4.0), [], uuid4(), ()
    )
    assert rules.judge_timing(due).apply_late_penalty(18.0) == LateAdjustedPoints(18.0)
    assert rules.judge_timing(due + second).apply_late_penalty(18.0) == LateAdjustedPoints(14.0, 1)
    assert rules.judge_timing(due + DAY).apply_late_penalty(18.0) == LateAdjustedPoints(14.0, 1)
    assert rules.judge_timing(due + DAY + second).apply_late_penalty(18.0) == LateAdjustedPoints(10.0, 2)
    assert rules.judge_timing(due + 3 * DAY).apply_late_penalty(5.0) == LateAdjustedPoints(0.0, 3)
    assert rules.judge_timing(due + 3 * DAY + second).apply_late_penalty(5.0) == NOT_COUNTED, "closed"
    assert rules.judge_timing(OPENS - second).apply_late_penalty(5.0) == LateAdjustedPoints(5.0), (
        "who works ahead is on time"
    )


def test_refused_and_accepted() -> None:
    late = OPENS + 7 * DAY + timedelta(minutes=1)
    refused, accepted = rules_in_force(Frame(late="refuse"), [], ADA, ()), rules_in_force(Frame(), [], ADA, ())
    assert refused.judge_timing(late).apply_late_penalty(20.0) == NOT_COUNTED
    assert refused.latest_counting_time == OPENS + 7 * DAY
    assert accepted.judge_timing(late).apply_late_penalty(20.0) == LateAdjustedPoints(20.0, 1)
    assert accepted.latest_counting_time == OPENS + 10 * DAY


@given(st.sampled_from([1.0, 4 / 3, 2.0]), st.integers(0, 9 * 24 * 60))
def test_extra_time_is_never_cut_off_by_the_end(factor: float, minutes: int) -> None:
    """Who begins as late as another who has the whole duration has the whole of their own."""
    frame = Frame(due_at=None, duration_minutes=60)
    own = Difference(account_id=ADA, time_factor=factor)
    began = OPENS + timedelta(minutes=minutes)
    rules = rules_in_force(frame, [own], ADA, ())
    end = rules.latest_sitting_end(began)
    common = rules_in_force(frame, [], BOB, ()).latest_sitting_end(began)
    assert end is not None
    assert common is not None
    assert end - began >= factor * (common - began) - timedelta(seconds=1)


def test_summer_time_moves_no_instant() -> None:
    """23:59 in Paris on the eve of the change and on the day after are 24 hours apart, but for the hour that goes."""
    eve = datetime(2026, 3, 28, 23, 59, tzinfo=PARIS)
    after = datetime(2026, 3, 29, 23, 59, tzinfo=PARIS)
    rules = rules_in_force(Frame(due_at=eve, late="penalty", late_per_day=1.0), [], ADA, ())
    assert rules.judge_timing(after).apply_late_penalty(20.0) == LateAdjustedPoints(19.0, 1)
    assert (after.astimezone(UTC) - eve.astimezone(UTC)) == timedelta(hours=23)
    same = rules_in_force(Frame(due_at=eve.astimezone(UTC)), [], ADA, ())
    assert same.judge_timing(eve).apply_late_penalty(20.0) == LateAdjustedPoints(20.0)
