"""What a regrade would do to whom: pure."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping, Sequence
from uuid import UUID

from server.assignments.counting import Sent
from server.regrades.models import Policy
from server.regrades.schemas import Change, Copy, Fate
from server.regrades.why import FAILED, Reason

DUST = 1e-6
#: From a student's attempts to what counts of them: which, and its points out of 20.
Marked = tuple[UUID, float] | None
Marker = Callable[[UUID, Sequence[Sent]], Marked]


def best(_student: UUID, attempts: Sequence[Sent]) -> Marked:
    """Of equals the earliest."""
    top = max(sorted(attempts, key=lambda one: (one.sent_at, str(one.id))), key=lambda one: one.score, default=None)
    return None if top is None else (top.id, 20.0 * top.score)


def moves(policy: Policy, copy: Copy) -> bool:
    """Whether the new grading is to count: never an error of ours, and always in the place of one."""
    if copy.after is None:
        return False
    return policy is Policy.renew or copy.before is None or copy.after >= copy.before - DUST


def changes(policy: Policy, copies: Iterable[Copy], marker: Marker) -> list[Change]:
    """One for each student. An attempt that waits stands as it is."""
    of_students: dict[UUID, list[Copy]] = defaultdict(list)
    for copy in copies:
        of_students[copy.account_id].append(copy)
    return [_change(policy, student, mine, marker) for student, mine in of_students.items()]


def _change(policy: Policy, student: UUID, copies: Sequence[Copy], marker: Marker) -> Change:
    def marked(score: Callable[[Copy], float | None]) -> Marked:
        found = ((copy, score(copy)) for copy in copies)
        return marker(
            student, [Sent(one.submission_id, one.sent_at, value) for one, value in found if value is not None]
        )

    before = marked(lambda one: one.before)
    after = marked(lambda one: one.after if moves(policy, one) else one.before)
    anew = marked(lambda one: one.before if one.after is None else one.after)
    fate = _fate(before, after, anew)
    deciding = [one[0] for one in (after if fate is not Fate.kept else anew, before) if one is not None]
    about, why = _why({copy.submission_id: copy for copy in copies}, deciding)
    return Change(
        student=student,
        before=_points(before),
        after=_points(after),
        anew=_points(anew),
        fate=fate,
        submission_id=about,
        why=why,
        copies=len(copies),
        failed=sum(copy.failed for copy in copies),
        waiting=sum(copy.after_id is None for copy in copies),
    )


def _points(marked: Marked) -> float | None:
    return None if marked is None else round(marked[1], 4)


def _fate(before: Marked, after: Marked, anew: Marked) -> Fate:
    was, becomes, alone = (-1.0 if one is None else one[1] for one in (before, after, anew))
    if becomes > was + DUST:
        return Fate.gains
    if becomes < was - DUST:
        return Fate.loses
    return Fate.kept if alone < was - DUST else Fate.same


def _why(copies: Mapping[UUID, Copy], deciding: Sequence[UUID]) -> tuple[UUID | None, tuple[Reason, ...]]:
    """Of the first attempt, of those that make the mark, of which another score or something else is told."""
    told = [copies[name] for name in dict.fromkeys(deciding) if copies[name].why and copies[name].why != (FAILED,)]
    told.sort(key=lambda copy: copy.before == copy.after)
    failed = [copy for copy in copies.values() if copy.failed]
    first = next(iter([*told, *failed]), None)
    return (None, ()) if first is None else (first.submission_id, first.why)
