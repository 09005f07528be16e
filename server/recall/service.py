"""What comes back to an account: its subjects, those that are due, and the reminder on the home page."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import feedback
from server.base import school_time
from server.course import Course, Exercise
from server.database import utc_now
from server.gradebook import mistakes
from server.gradebook.mistakes import PastMistake
from server.recall import repository, retrievals
from server.recall.models import RecallAnswer
from server.recall.scheduling import (
    Review,
    Schedule,
    choose_subjects_for_today,
    compute_schedule,
    count_streak_with_forgiven_gaps,
    sort_due_subjects,
)
from server.recall.subjects import iter_misconceptions, subject_of_misconception

REMINDERS, OFF = "reminders", "off"


@dataclass(frozen=True)
class RecallCandidate:
    """A misconception about which a question may be asked."""

    exercise: str
    misconception: str


@dataclass(frozen=True)
class RecallState:
    """What comes back to an account. `due` are subjects, the most forgotten first, each with what may be asked:
    misconceptions, or none where the subject is a retrieval question itself.

    `fading` are all subjects that are due, whether or not a day is long enough for them, with what was confused.
    """

    due: Mapping[str, Sequence[RecallCandidate]]
    fading: Mapping[str, Sequence[RecallCandidate]]
    answered_today: int
    answers: Mapping[str, int]
    streak: int
    next_at: datetime | None
    is_off: bool


def load_account_recall_state(
    db: Session,
    course: Course,
    account_id: UUID,
    solved: Collection[str],
    can_ask: Callable[[Exercise], bool],
    choices: Mapping[str, str],
) -> RecallState:
    """Load what comes back: of the solved exercises about which questions can be asked, and of lessons.

    A question of a lesson is scheduled from its first wrong answer on. Nothing is asked of an exercise during its test.

    `choices` are the account's, as `repository.load_choices` loads them.
    """
    now = utc_now()
    today = school_time.to_local(now).date()
    held = feedback.load_holds_by_exercise(db, account_id) if solved else {}
    tested = {name for name, holds in held.items() if holds.tests}
    asked = [course.exercises[name] for name in course.exercises if name in solved and name not in tested]
    past = mistakes.load_past_mistakes(db, account_id, [exercise.id for exercise in asked]) if asked else ()
    answers = repository.load_recall_answers(db, account_id)
    reviews, confused = collect_reviews_by_subject(course, past, answers, can_ask)
    days = [school_time.to_local(answer.answered_at).date() for answer in answers]
    schedules: dict[str, Schedule] = {subject: compute_schedule(history, now) for subject, history in reviews.items()}
    answered_today, counts = days.count(today), Counter(answer.subject for answer in answers)
    due = choose_subjects_for_today(schedules, now, answered_today)
    return RecallState(
        due={
            subject: (*confused.get(subject, ()), *list_family_candidates(course, asked, subject, can_ask))
            for subject in due
        },
        fading={subject: confused.get(subject, ()) for subject in sort_due_subjects(schedules, now)},
        answered_today=answered_today,
        answers={subject: counts[subject] for subject in due},
        streak=count_streak_with_forgiven_gaps(days, today),
        next_at=min((planned.due_at for planned in schedules.values()), default=None),
        is_off=choices.get(REMINDERS) == OFF,
    )


def collect_reviews_by_subject(
    course: Course,
    past: Iterable[PastMistake],
    answers: Iterable[RecallAnswer],
    can_ask: Callable[[Exercise], bool],
) -> tuple[Mapping[str, Sequence[Review]], Mapping[str, Sequence[RecallCandidate]]]:
    """Return the reviews of each subject, and the mended misconceptions of it about which one may ask. Pure.

    An answer about what was never confused counts for a lesson's question that was missed, and for nothing else.
    """
    reviews: dict[str, list[Review]] = defaultdict(list)
    confused: dict[str, list[RecallCandidate]] = defaultdict(list)
    for mistake in past:
        exercise = course.exercises[mistake.exercise]
        if mistake.mended is not None and can_ask(exercise):
            subject = subject_of_misconception(course, exercise, mistake.misconception)
            reviews[subject].append(Review(mistake.mended.sent_at, went_well=False))
            confused[subject].append(RecallCandidate(exercise.id, mistake.misconception))
    for answer in answers:
        is_missed = not answer.is_right and retrievals.find_retrieval_of_subject(course, answer.subject) is not None
        if answer.subject in reviews or is_missed:
            reviews[answer.subject].append(Review(answer.answered_at, answer.is_right))
    return reviews, confused


def list_family_candidates(
    course: Course, solved: Sequence[Exercise], subject: str, can_ask: Callable[[Exercise], bool]
) -> Sequence[RecallCandidate]:
    """List the misconceptions of the same family in solved exercises: another program than the one confused."""
    if subject not in course.families:
        return ()
    return [
        RecallCandidate(exercise.id, name)
        for exercise in solved
        if subject in exercise.filing.families.values() and can_ask(exercise)
        for name in iter_misconceptions(exercise)
        if exercise.filing.families.get(name) == subject
    ]
