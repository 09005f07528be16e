"""An attempt as it is shown: what was sent, with the grading that counts, and whether anything may be held back from
its author. It is read as columns, for every page that shows one; what is given back is no session's, and is changed by
nobody."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Any, NamedTuple
from uuid import UUID

from sqlalchemy import Select, bindparam, select
from sqlalchemy.orm import Session

from server.assignments import feedback_repository
from server.database import ask, loaded, prepared, table_of, utc_now
from server.gradebook.models import Grading
from server.submissions.models import Submission

_submissions, _gradings = table_of(Submission), table_of(Grading)
_SENT = tuple(_submissions.c)
#: All but what it has drawn, which is long, and asked for by itself.
_COUNTING = tuple(one for one in _gradings.c if one.name not in {"figures", "films"})
_NAMES = tuple(one.name for one in _SENT), tuple(one.name for one in _COUNTING)
WHOLE = select(*_SENT, *_COUNTING, feedback_repository.has_holds_clause(_submissions)).select_from(
    _submissions.outerjoin(_gradings, _gradings.c.id == _submissions.c.grading_id)
)
ATTEMPT = WHOLE.where(_submissions.c.id == bindparam("submission"))


class StoredAttempt(NamedTuple):
    """`may_be_held`: the author's assignments are to be looked at."""

    submission: Submission
    grading: Grading | None
    may_be_held: bool


def load_attempt(db: Session, submission_id: UUID) -> StoredAttempt | None:
    """A submission with the grading that counts, as they stand now."""
    return _whole(ask(db, ATTEMPT, {"submission": submission_id, "now": utc_now()}).one_or_none())


def _whole(row: Sequence[Any] | None) -> StoredAttempt | None:
    if row is None:
        return None
    sent, counting = _NAMES
    submission = loaded(Submission, zip(sent, row, strict=False))
    if submission.grading_id is None:
        return StoredAttempt(submission, None, row[-1])
    return StoredAttempt(submission, loaded(Grading, zip(counting, row[len(sent) : -1], strict=True)), row[-1])


@prepared
def _latest(account_id: UUID, exercise: str, now: datetime) -> Select[*tuple[Any, ...]]:
    """`now` is that of `held.anything`."""
    sent = _submissions.c
    query = WHOLE.where(sent.account_id == account_id, sent.exercise == exercise)
    return query.order_by(sent.created_at.desc(), sent.id.desc()).limit(1)


def load_latest_attempt(db: Session, account_id: UUID, exercise: str) -> StoredAttempt | None:
    """The one that was sent last."""
    return _whole(ask(db, *_latest(account_id, exercise, utc_now())).one_or_none())
