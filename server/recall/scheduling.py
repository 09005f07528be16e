"""When what was confused is asked again: FSRS's scheduler on the history of answers. Pure.

A confusion counts as a failed review when it was mended, an answer as a review that failed or went well. Nothing of a
schedule is stored: it follows from the history.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import date, datetime, timedelta

from fsrs import Card, Rating, Scheduler

#: Reviews are whole days apart, and the same history gives the same day.
SCHEDULER = Scheduler(
    desired_retention=0.9, learning_steps=(), relearning_steps=(), maximum_interval=365, enable_fuzzing=False
)
#: Questions of one sitting, and of one day: at half a minute each, two and four minutes.
SITTING_QUESTIONS, DAILY_QUESTIONS = 4, 8
#: Days without an answer that do not end a streak.
FORGIVEN_DAYS = 7


@dataclass(frozen=True)
class Review:
    """A confusion or an answer, at a time in UTC."""

    at: datetime
    went_well: bool


@dataclass(frozen=True)
class Schedule:
    """When a subject is due, and how likely it is still known at a moment (0 to 1)."""

    due_at: datetime
    retrievability: float


def compute_schedule(reviews: Iterable[Review], now: datetime) -> Schedule:
    """Return the schedule that follows from some reviews, at least one."""
    card = Card(card_id=1)
    for review in sorted(reviews, key=lambda review: review.at):
        card, _ = SCHEDULER.review_card(card, Rating.Good if review.went_well else Rating.Again, review.at)
    return Schedule(card.due, SCHEDULER.get_card_retrievability(card, now))


def sort_due_subjects(schedules: Mapping[str, Schedule], now: datetime) -> Sequence[str]:
    """Return the subjects that are due, the most forgotten first."""
    due = [name for name in schedules if schedules[name].due_at <= now]
    return sorted(due, key=lambda name: (schedules[name].retrievability, name))


def choose_subjects_for_today(schedules: Mapping[str, Schedule], now: datetime, answered_today: int) -> Sequence[str]:
    """Return the subjects to ask now, the most forgotten first, within what one day takes."""
    due = sort_due_subjects(schedules, now)
    return due[: max(0, min(SITTING_QUESTIONS, DAILY_QUESTIONS - answered_today))]


def count_streak_with_forgiven_gaps(days: Collection[date], today: date) -> int:
    """Count the days with answers in a row, between which no more than `FORGIVEN_DAYS` passed."""
    streak, after = 0, today
    for day in sorted(set(days), reverse=True):
        if after - day > timedelta(days=FORGIVEN_DAYS):
            break
        streak, after = streak + 1, day
    return streak
