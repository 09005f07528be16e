"""A submission as the API shows it."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import Verdict
from server.database import Database
from server.gradebook import service as gradebook
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.submissions.models import State
from server.submissions.service import UNATTENDED, Submissions


@dataclass(frozen=True)
class Resource:
    """The JSON members of a submission (`api.schemas.SubmissionOut`)."""

    id: UUID
    members: dict[str, Any]

    @property
    def done(self) -> bool:
        return bool(self.members["status"] == State.done)

    def text(self) -> str:
        return json.dumps(self.members, ensure_ascii=False, allow_nan=False)


def url_of(submission_id: UUID) -> str:
    return f"/api/v1/submissions/{submission_id}"


def resource(db: Session, store: Submissions, attempt: Attempt) -> Resource:
    submission = attempt.submission
    place = store.place(db, submission)
    return Resource(
        submission.id,
        {
            "id": str(submission.id),
            "status": place.state,
            "position": place.position,
            "notice": UNATTENDED if place.unattended else None,
            "verdict": Verdict.from_json(attempt.grading.verdict).to_json() if attempt.grading else None,
            "url": url_of(submission.id),
            "exercise": submission.exercise,
            "created_at": submission.created_at.isoformat(),
        },
    )


def reader(database: Database, store: Submissions, account: Account, submission_id: UUID) -> Callable[[], Resource]:
    """Reads the submission afresh, in a transaction of its own."""

    def read() -> Resource:
        with database.read() as db:
            return resource(db, store, gradebook.find(db, account, submission_id))

    return read
