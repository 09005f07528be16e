"""An attempt as it is shown: what was sent, with the grading that counts. It is read as columns, for every page that
shows one; what is given back is no session's, and is changed by nobody."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any
from uuid import UUID

from sqlalchemy import Select, bindparam, select
from sqlalchemy.orm import Session

from server.database import ask, loaded, prepared, table_of
from server.gradebook.models import Grading
from server.submissions.models import Submission

_submissions, _gradings = table_of(Submission), table_of(Grading)
_SENT = tuple(_submissions.c)
#: All but what it has drawn, which is long, and asked for by itself.
_COUNTING = tuple(one for one in _gradings.c if one.name not in {"figures", "films"})
_NAMES = tuple(one.name for one in _SENT), tuple(one.name for one in _COUNTING)
WHOLE = select(*_SENT, *_COUNTING).select_from(
    _submissions.outerjoin(_gradings, _gradings.c.id == _submissions.c.grading_id)
)
ATTEMPT = WHOLE.where(_submissions.c.id == bindparam("submission"))


def attempt(db: Session, submission_id: UUID) -> tuple[Submission, Grading | None] | None:
    """A submission with the grading that counts, as they stand now."""
    return _whole(ask(db, ATTEMPT, {"submission": submission_id}).one_or_none())


def _whole(row: Sequence[Any] | None) -> tuple[Submission, Grading | None] | None:
    if row is None:
        return None
    sent, counting = _NAMES
    submission = loaded(Submission, zip(sent, row, strict=False))
    if submission.grading_id is None:
        return submission, None
    return submission, loaded(Grading, zip(counting, row[len(sent) :], strict=True))


@prepared
def _latest(account_id: UUID, exercise: str) -> Select[*tuple[Any, ...]]:
    sent = _submissions.c
    query = WHOLE.where(sent.account_id == account_id, sent.exercise == exercise)
    return query.order_by(sent.created_at.desc(), sent.id.desc()).limit(1)


def latest(db: Session, account_id: UUID, exercise: str) -> tuple[Submission, Grading | None] | None:
    """The one that was sent last."""
    return _whole(ask(db, *_latest(account_id, exercise)).one_or_none())
