"""What is due soon for who looks, as the first page, a module's and an exercise's tell it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta

from sqlalchemy.orm import Session

from server.assignments import mine
from server.assignments.mine import Mine
from server.assignments.states import Stage
from server.database import utc_now
from server.gradebook.schemas import NOTHING_YET, Progress
from server.identity.models import Account
from server.web.words import moment, moment_words

SOON = timedelta(days=7)
MOST = 5  # lines on a page


@dataclass(frozen=True)
class DueView:
    """An assignment that is due; `late`: its due date has gone by, and until `when` what is sent counts still.

    `left` is how many of its exercises are not solved. Without a date both of `when` are empty.
    """

    title: str
    href: str
    when: str
    when_text: str
    late: bool
    left: int


def soon(
    db: Session, account: Account | None, progress: Mapping[str, Progress], module: str | None = None
) -> tuple[DueView, ...]:
    """What is due within a week, or late, and not done yet; of one module, or of all. Three queries at most."""
    if account is None:
        return ()
    now = utc_now()
    found = mine.due_within(mine.running(db, account.id, now), now, SOON)
    views = _views((one for one in found if _is_of(one, module)), progress)
    return tuple(view for view in views if view.left)[:MOST]


def _is_of(one: Mine, module: str | None) -> bool:
    return module is None or any(row.exercise.startswith(f"{module}/") for row in one.exercises)


def of_exercise(db: Session, account: Account | None, exercise: str) -> tuple[DueView, ...]:
    """The assignments that ask one for this exercise now. Three queries at most, one where there is none."""
    if account is None:
        return ()
    found = mine.running(db, account.id, utc_now(), exercise)
    return tuple(_views((one for one in found if not one.rules.excused), {}))[:MOST]


def _views(found: Iterable[Mine], progress: Mapping[str, Progress]) -> Sequence[DueView]:
    return [_view(one, progress) for one in found]


def _view(one: Mine, progress: Mapping[str, Progress]) -> DueView:
    late = one.stage is Stage.late
    when: datetime | None = one.rules.closes_at if late else one.rules.due_at
    return DueView(
        title=one.assignment.title,
        href=f"/classes/{one.assignment.class_id}#devoir-{one.assignment.id}",
        when="" if when is None else moment(when),
        when_text="" if when is None else moment_words(when),
        late=late,
        left=sum(not progress.get(row.exercise, NOTHING_YET).succeeded for row in one.exercises),
    )
