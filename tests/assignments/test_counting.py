"""Which attempt counts: against a search through all of them."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from uuid import UUID

from hypothesis import given
from hypothesis import strategies as st

from server.assignments.counting import ScoredAttempt, mark_attempts
from server.assignments.models import AttemptSelection
from server.assignments.rules import rules_in_force
from tests.assignments.test_rules import DAY, OPENS, Frame

RULES = rules_in_force(Frame(late="penalty", late_per_day=3.0), [], UUID(int=1), ())
attempts = st.lists(
    st.tuples(st.integers(-24, 12 * 24), st.sampled_from([0.0, 0.25, 0.5, 0.9, 1.0])),
    max_size=8,
    unique_by=lambda p: p[0],
).map(
    lambda rows: [ScoredAttempt(UUID(int=n), OPENS + timedelta(hours=at), score) for n, (at, score) in enumerate(rows)]
)


@given(attempts)
def test_the_best_is_what_no_other_beats(sent: list[ScoredAttempt]) -> None:
    worths = {one.id: RULES.judge_timing(one.sent_at).apply_late_penalty(20 * one.score) for one in sent}
    counting = {name: worth.points for name, worth in worths.items() if worth.points is not None}
    best, last = mark_attempts(RULES, AttemptSelection.best, sent), mark_attempts(RULES, AttemptSelection.last, sent)
    assert best.attempts == len(counting)
    assert (best.counted is None) == (not counting)
    if best.counted is not None and last.counted is not None:
        assert best.counted.points == max(counting.values())
        latest = max((one for one in sent if one.id in counting), key=lambda one: one.sent_at)
        assert last.counted.attempt == latest.id
    on_time = [one for one in sent if one.sent_at <= OPENS + 7 * DAY]
    before = mark_attempts(RULES, AttemptSelection.best_before_due, sent).counted
    assert (before.points if before else None) == max((20 * one.score for one in on_time), default=None)


@given(attempts)
def test_the_order_in_which_they_are_read_is_nothing(sent: list[ScoredAttempt]) -> None:
    for counts in AttemptSelection:
        assert mark_attempts(RULES, counts, sent) == mark_attempts(RULES, counts, sent[::-1])


def test_an_attempt_before_the_opening_is_on_time() -> None:
    early = ScoredAttempt(UUID(int=1), datetime(2020, 1, 1, tzinfo=UTC), 1.0)
    found = mark_attempts(RULES, AttemptSelection.best, [early])
    assert found.counted is not None
    assert (found.counted.points, found.counted.days_late) == (20.0, 0)
