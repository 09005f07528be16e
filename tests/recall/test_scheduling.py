"""Due questions come when they should, to simulated students who forget, and take no more than minutes a day."""

from __future__ import annotations

import math
from datetime import UTC, date, datetime, timedelta

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from server.recall.scheduling import (
    DAILY_QUESTIONS,
    SITTING_QUESTIONS,
    Review,
    choose_subjects_for_today,
    compute_schedule,
    count_streak_with_forgiven_gaps,
)

START = datetime(2026, 9, 1, 18, 0, tzinfo=UTC)
MINUTES_A_QUESTION = 0.6


def test_what_is_known_comes_back_later_and_later_and_what_is_not_the_next_day() -> None:
    reviews, at, gaps = [Review(START, went_well=False)], START, []
    for _ in range(5):
        due = compute_schedule(reviews, at).due_at
        gaps.append((due - at).days)
        at = due
        reviews.append(Review(at, went_well=True))
    assert gaps[0] == 1
    assert gaps == sorted(gaps)
    assert 14 <= gaps[3] <= 21
    failed = [*reviews[:-1], Review(at, went_well=False)]
    assert (compute_schedule(failed, at).due_at - at).days <= 7 < gaps[4]


class ForgetfulStudent:
    """Remembers a subject with probability exp(-days / strength); a success strengthens it, a failure weakens it."""

    def __init__(self, seed: int, subjects: int, confusions_a_week: float) -> None:
        self.rng = np.random.default_rng(seed)
        self.reviews: dict[str, list[Review]] = {}
        self.strength: dict[str, float] = {}
        self.subjects, self.rate = subjects, confusions_a_week / 7

    def live_a_day(self, now: datetime) -> list[tuple[str, bool]]:
        """Confuse something at times, and answer what is due in the sittings that one day allows."""
        if self.rng.random() < self.rate:
            name = f"s{self.rng.integers(self.subjects)}"
            self.reviews.setdefault(name, []).append(Review(now - timedelta(hours=2), went_well=False))
            self.strength[name] = 2.0
        answered: list[tuple[str, bool]] = []
        while due := choose_subjects_for_today(
            {name: compute_schedule(reviews, now) for name, reviews in self.reviews.items()}, now, len(answered)
        ):
            for name in due:
                days = (now - self.reviews[name][-1].at) / timedelta(days=1)
                knows = bool(self.rng.random() < math.exp(-days / self.strength[name] / 8))
                self.strength[name] = self.strength[name] * 2.5 if knows else 2.0
                self.reviews[name].append(Review(now, went_well=knows))
                answered.append((name, knows))
        return answered


@settings(max_examples=4, deadline=None)
@given(seed=st.integers(0, 2**32), subjects=st.integers(1, 40), confusions=st.floats(0.5, 7))
def test_two_months_of_a_forgetful_student_takes_no_more_than_five_minutes_a_day(
    seed: int, subjects: int, confusions: float
) -> None:
    student = ForgetfulStudent(seed, subjects, confusions)
    asked_in_all = 0
    for day in range(60):
        now = START + timedelta(days=day)
        answered = student.live_a_day(now)
        asked_in_all += len(answered)
        assert len(answered) * MINUTES_A_QUESTION <= 5
        left = {name: compute_schedule(reviews, now) for name, reviews in student.reviews.items()}
        if len(answered) < DAILY_QUESTIONS:
            assert not [name for name in left if left[name].due_at <= now], "what is due is asked"
        assert len(set(answered)) == len(answered), "nothing is asked twice in a day"
    assert asked_in_all or not student.reviews


def test_the_most_forgotten_come_first_and_a_sitting_is_short() -> None:
    later = START + timedelta(days=30)
    once = {f"s{k}": compute_schedule([Review(START + timedelta(days=k), went_well=False)], later) for k in range(9)}
    assert choose_subjects_for_today(once, later, 0) == ["s0", "s1", "s2", "s3"][:SITTING_QUESTIONS]
    assert len(choose_subjects_for_today(once, later, DAILY_QUESTIONS - 1)) == 1
    assert choose_subjects_for_today(once, later, DAILY_QUESTIONS) == []
    assert choose_subjects_for_today(once, START, 0) == []


def test_a_streak_forgives_a_week() -> None:
    today = date(2026, 11, 28)
    assert count_streak_with_forgiven_gaps([], today) == 0
    assert count_streak_with_forgiven_gaps([date(2026, 11, 21), date(2026, 11, 27), date(2026, 11, 27)], today) == 2
    assert count_streak_with_forgiven_gaps([date(2026, 11, 10), date(2026, 11, 21)], today) == 1
    assert count_streak_with_forgiven_gaps([date(2026, 11, 20)], today) == 0
