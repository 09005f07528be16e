"""A submission as the API shows it."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from uuid import UUID

from sqlalchemy.orm import Session

from server.behaviour import service as behaviour
from server.database import Database
from server.gradebook import service as gradebook
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.submissions.models import State
from server.submissions.service import UNATTENDED, Submissions


@dataclass(frozen=True)
class Resource:
    """A submission as JSON (`api.schemas.SubmissionOut`), written in the thread that reads it: the loop passes it on.

    A verdict is what a student's program made of it, within `graders.core.contract.bounds`.
    """

    id: UUID
    done: bool
    text: str


def url_of(submission_id: UUID) -> str:
    return f"/api/v1/submissions/{submission_id}"


def resource(db: Session, store: Submissions, attempt: Attempt) -> Resource:
    submission = attempt.submission
    place = store.place(db, submission)
    verdict = behaviour.verdict_of(db, attempt)
    members = {
        "id": str(submission.id),
        "status": place.state,
        "position": place.position,
        "notice": UNATTENDED if place.unattended else None,
        "verdict": verdict.to_json() if verdict else None,
        "url": url_of(submission.id),
        "exercise": submission.exercise,
        "created_at": submission.created_at.isoformat(),
    }
    text = json.dumps(members, ensure_ascii=False, allow_nan=False)
    return Resource(submission.id, place.state == State.done, text)


def reader(database: Database, store: Submissions, account: Account, submission_id: UUID) -> Callable[[], Resource]:
    """Reads the submission afresh, in a transaction of its own."""

    def read() -> Resource:
        with database.read() as db:
            return resource(db, store, gradebook.find(db, account, submission_id))

    return read
