"""The misconceptions that an account's attempts have shown, exercise by exercise, and the attempts that mended them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from typing import Any
from uuid import UUID

from sqlalchemy import select
from sqlalchemy.orm import Session

from server.assignments import feedback
from server.gradebook.histories import Attempts, GradedAttempt
from server.gradebook.models import Grading
from server.submissions.models import Submission

MAX_ATTEMPTS = 2000


@dataclass(frozen=True)
class PastMistake:
    """A misconception that attempts at one exercise showed, `attempts` of them, from `first` to `last`.

    `mended` is the first attempt after these that scored more than the last of them, None while there is none.
    """

    misconception: str
    first: GradedAttempt
    last: GradedAttempt
    attempts: int
    mended: GradedAttempt | None

    @property
    def exercise(self) -> str:
        return self.last.exercise


def load_past_mistakes(
    db: Session, account_id: UUID, exercises: Collection[str] | None = None
) -> tuple[PastMistake, ...]:
    """Load the misconceptions that an account may know of, in these exercises or in all, the latest shown first."""
    attempts = load_attempts_with_feedback(db, account_id, exercises)
    mistakes = [mistake for series in attempts.values() for mistake in iter_past_mistakes(series)]
    return tuple(sorted(mistakes, key=lambda mistake: mistake.last.sent_at, reverse=True))


def load_attempts_with_feedback(
    db: Session, account_id: UUID, exercises: Collection[str] | None = None
) -> Mapping[str, Attempts]:
    """Load an account's latest graded attempts by exercise, `MAX_ATTEMPTS` at most, the oldest first.

    Attempts whose mistake a test or an assignment holds back are left out, as are internal errors.
    """
    columns = (
        *(Submission.id, Submission.created_at, Grading.score, Submission.account_id, Submission.exercise),
        *(Submission.digest, Grading.outcome, Grading.diagnosis, Grading.id),
    )
    query = (
        select(*columns)
        .join(Grading, Grading.id == Submission.grading_id)
        .where(Submission.account_id == account_id, Grading.score.is_not(None))
    )
    if exercises is not None:
        query = query.where(Submission.exercise.in_(exercises))
    rows: Sequence[Any] = db.execute(
        query.order_by(Submission.created_at.desc(), Submission.id.desc()).limit(MAX_ATTEMPTS)
    ).all()
    holds = feedback.load_holds_by_exercise(db, account_id) if rows else {}
    attempts = [
        attempt
        for attempt in (GradedAttempt(*row) for row in reversed(rows))
        if (held := holds.get(attempt.exercise)) is None
        or (held.diagnosis is None and held.find_withholding_test(attempt.sent_at) is None)
    ]
    by_exercise = attrgetter("exercise")
    return {name: tuple(series) for name, series in groupby(sorted(attempts, key=by_exercise), by_exercise)}


def iter_past_mistakes(attempts: Attempts) -> Iterator[PastMistake]:
    """Yield each misconception that attempts at one exercise show, the oldest attempt first. Pure."""
    indices: dict[str, list[int]] = {}
    for index, attempt in enumerate(attempts):
        if attempt.diagnosis is not None:
            indices.setdefault(attempt.diagnosis, []).append(index)
    for misconception, shown in indices.items():
        last = attempts[shown[-1]]
        yield PastMistake(
            misconception, attempts[shown[0]], last, len(shown), find_better_attempt(last, attempts[shown[-1] + 1 :])
        )


def find_better_attempt(attempt: GradedAttempt, later: Iterable[GradedAttempt]) -> GradedAttempt | None:
    """Return the first of later attempts that scored more. Pure."""
    return next((other for other in later if other.score > attempt.score), None)


def load_submission_sources(db: Session, submissions: Collection[UUID]) -> Mapping[UUID, bytes]:
    """Load what was sent in these submissions."""
    rows = db.execute(select(Submission.id, Submission.source).where(Submission.id.in_(submissions)))
    return dict(rows.all())
