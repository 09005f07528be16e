"""What a regrade would do to whom: pure."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from uuid import UUID

from server.assignments.counting import ScoredAttempt
from server.regrades.differences import FAILED, VerdictDifference
from server.regrades.models import RegradePolicy
from server.regrades.schemas import MarkChange, MarkOutcome, RegradedAttempt

DUST = 1e-6
#: From a student's attempts to what counts of them: which, and its points out of 20.
CountedMark = tuple[UUID, float] | None
Marker = Callable[[UUID, Sequence[ScoredAttempt]], CountedMark]


def best_mark(_student: UUID, attempts: Sequence[ScoredAttempt]) -> CountedMark:
    """Of equals the earliest."""
    top = max(sorted(attempts, key=lambda one: (one.sent_at, str(one.id))), key=lambda one: one.score, default=None)
    return None if top is None else (top.id, 20.0 * top.score)


def counts_when_applied(policy: RegradePolicy, copy: RegradedAttempt) -> bool:
    """Whether the new grading is to count: never an error of ours, and always in the place of one."""
    if copy.after is None:
        return False
    return policy is RegradePolicy.renew or copy.before is None or copy.after >= copy.before - DUST


def compute_changes(policy: RegradePolicy, copies: Iterable[RegradedAttempt], marker: Marker) -> list[MarkChange]:
    """One for each student. An attempt that waits stands as it is."""
    of_students: dict[UUID, list[RegradedAttempt]] = defaultdict(list)
    for copy in copies:
        of_students[copy.account_id].append(copy)
    return [_change(policy, student, mine, marker) for student, mine in of_students.items()]


def _change(policy: RegradePolicy, student: UUID, copies: Sequence[RegradedAttempt], marker: Marker) -> MarkChange:
    def marked(score: Callable[[RegradedAttempt], float | None]) -> CountedMark:
        found = ((copy, score(copy)) for copy in copies)
        return marker(
            student, [ScoredAttempt(one.submission_id, one.sent_at, value) for one, value in found if value is not None]
        )

    before = marked(lambda one: one.before)
    after = marked(lambda one: one.after if counts_when_applied(policy, one) else one.before)
    anew = marked(lambda one: one.before if one.after is None else one.after)
    fate = _fate(before, after, anew)
    deciding = [one[0] for one in (after if fate is not MarkOutcome.kept else anew, before) if one is not None]
    about, why = _why({copy.submission_id: copy for copy in copies}, deciding)
    return MarkChange(
        student=student,
        before=_points(before),
        after=_points(after),
        new_only=_points(anew),
        outcome=fate,
        submission_id=about,
        differences=why,
        attempts=len(copies),
        failed=sum(copy.failed for copy in copies),
        waiting=sum(copy.after_id is None for copy in copies),
    )


def _points(marked: CountedMark) -> float | None:
    return None if marked is None else round(marked[1], 4)


def _fate(before: CountedMark, after: CountedMark, anew: CountedMark) -> MarkOutcome:
    was, becomes, alone = (-1.0 if one is None else one[1] for one in (before, after, anew))
    if becomes > was + DUST:
        return MarkOutcome.gains
    if becomes < was - DUST:
        return MarkOutcome.loses
    return MarkOutcome.kept if alone < was - DUST else MarkOutcome.same


def _why(
    copies: Mapping[UUID, RegradedAttempt], deciding: Sequence[UUID]
) -> tuple[UUID | None, tuple[VerdictDifference, ...]]:
    """Of the first attempt, of those that make the mark, of which another score or something else is told."""
    told = [
        copies[name]
        for name in dict.fromkeys(deciding)
        if copies[name].differences and copies[name].differences != (FAILED,)
    ]
    told.sort(key=lambda copy: copy.before == copy.after)
    failed = [copy for copy in copies.values() if copy.failed]
    first = next(iter([*told, *failed]), None)
    return (None, ()) if first is None else (first.submission_id, first.differences)
