"""The effect of a regrade on students' marks. Pure functions."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from uuid import UUID

from server.assignments.counting import ScoredAttempt
from server.regrades.differences import FAILED, VerdictDifference
from server.regrades.models import RegradePolicy
from server.regrades.schemas import MarkChange, MarkOutcome, RegradedAttempt

TOLERANCE = 1e-6
#: The attempt that counts, and its points out of 20; None without any.
CountedMark = tuple[UUID, float] | None
#: Chooses the mark that counts among a student's attempts.
Marker = Callable[[UUID, Sequence[ScoredAttempt]], CountedMark]


def mark_by_best_attempt(_student: UUID, attempts: Sequence[ScoredAttempt]) -> CountedMark:
    """Return the best attempt; among equal scores the earliest."""
    in_order = sorted(attempts, key=lambda attempt: (attempt.sent_at, str(attempt.id)))
    best = max(in_order, key=lambda attempt: attempt.score, default=None)
    return None if best is None else (best.id, 20.0 * best.score)


def does_new_grading_count(policy: RegradePolicy, attempt: RegradedAttempt) -> bool:
    """Whether the new grading is to count: never an internal error, and always in place of one."""
    if attempt.after is None:
        return False
    return policy is RegradePolicy.renew or attempt.before is None or attempt.after >= attempt.before - TOLERANCE


def compute_mark_changes(
    policy: RegradePolicy, attempts: Iterable[RegradedAttempt], marker: Marker
) -> list[MarkChange]:
    """Return the change of each student's mark. Attempts that are not regraded yet keep their score."""
    by_student: dict[UUID, list[RegradedAttempt]] = defaultdict(list)
    for attempt in attempts:
        by_student[attempt.account_id].append(attempt)
    return [
        _compute_student_change(policy, student, own_attempts, marker) for student, own_attempts in by_student.items()
    ]


def _compute_student_change(
    policy: RegradePolicy, student: UUID, attempts: Sequence[RegradedAttempt], marker: Marker
) -> MarkChange:
    def mark(score_of: Callable[[RegradedAttempt], float | None]) -> CountedMark:
        scores = ((attempt, score_of(attempt)) for attempt in attempts)
        scored = [
            ScoredAttempt(attempt.submission_id, attempt.sent_at, score)
            for attempt, score in scores
            if score is not None
        ]
        return marker(student, scored)

    before = mark(lambda attempt: attempt.before)
    after = mark(lambda attempt: attempt.after if does_new_grading_count(policy, attempt) else attempt.before)
    new_only = mark(lambda attempt: attempt.before if attempt.after is None else attempt.after)
    outcome = _classify_mark_outcome(before, after, new_only)
    marks = (after if outcome is not MarkOutcome.kept else new_only, before)
    deciding = [mark[0] for mark in marks if mark is not None]
    submission_id, differences = _find_explaining_attempt(
        {attempt.submission_id: attempt for attempt in attempts}, deciding
    )
    return MarkChange(
        student=student,
        before=_points_or_none(before),
        after=_points_or_none(after),
        new_only=_points_or_none(new_only),
        outcome=outcome,
        submission_id=submission_id,
        differences=differences,
        attempts=len(attempts),
        failed=sum(attempt.is_failed for attempt in attempts),
        waiting=sum(attempt.after_id is None for attempt in attempts),
    )


def _points_or_none(mark: CountedMark) -> float | None:
    return None if mark is None else round(mark[1], 4)


def _classify_mark_outcome(before: CountedMark, after: CountedMark, new_only: CountedMark) -> MarkOutcome:
    old, new, unprotected = (-1.0 if mark is None else mark[1] for mark in (before, after, new_only))
    if new > old + TOLERANCE:
        return MarkOutcome.gains
    if new < old - TOLERANCE:
        return MarkOutcome.loses
    return MarkOutcome.kept if unprotected < old - TOLERANCE else MarkOutcome.same


def _find_explaining_attempt(
    attempts: Mapping[UUID, RegradedAttempt], deciding: Sequence[UUID]
) -> tuple[UUID | None, tuple[VerdictDifference, ...]]:
    """Return the attempt that explains a change, with its differences: a deciding one, best with another score."""
    candidates = [attempts[submission_id] for submission_id in dict.fromkeys(deciding)]
    explained = [attempt for attempt in candidates if attempt.differences and attempt.differences != (FAILED,)]
    explained.sort(key=lambda attempt: attempt.before == attempt.after)
    failed = [attempt for attempt in attempts.values() if attempt.is_failed]
    first = next(iter([*explained, *failed]), None)
    return (None, ()) if first is None else (first.submission_id, first.differences)
