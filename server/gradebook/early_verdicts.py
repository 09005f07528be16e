"""Verdicts of submissions whose checks have ended, while the name of their mistake is sought."""

from __future__ import annotations

from uuid import UUID

from sqlalchemy import delete, insert, select
from sqlalchemy.orm import Session

from graders.core.contract.bounds import limit_size
from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Verdict
from server.gradebook.models import EarlyVerdict
from server.submissions.models import Submission


def store_early_verdict(db: Session, submission_id: UUID, verdict: Verdict) -> bool:
    """Store the verdict of a submission without its diagnosis; False where the submission is gone or is graded."""
    waiting = select(Submission.id).where(Submission.id == submission_id, Submission.grading_id.is_(None))
    if db.execute(waiting).one_or_none() is None:
        return False
    delete_early_verdict(db, submission_id)
    written = limit_size(Judgement(verdict)).verdict.to_json()
    db.execute(insert(EarlyVerdict).values(submission_id=submission_id, verdict=written))
    return True


def load_early_verdict(db: Session, submission_id: UUID) -> Verdict | None:
    """Return the stored verdict of a submission; None where there is none."""
    query = select(EarlyVerdict.verdict).where(EarlyVerdict.submission_id == submission_id)
    stored = db.execute(query).scalar_one_or_none()
    return None if stored is None else Verdict.from_json(stored)


def has_early_verdict(db: Session, submission_id: UUID) -> bool:
    """Whether there is a verdict to show while a submission is graded."""
    query = select(EarlyVerdict.submission_id).where(EarlyVerdict.submission_id == submission_id)
    return db.execute(query).one_or_none() is not None


def delete_early_verdict(db: Session, submission_id: UUID) -> None:
    """Forget the verdict of a submission, once it is graded."""
    db.execute(delete(EarlyVerdict).where(EarlyVerdict.submission_id == submission_id))
