"""A submission as the API shows it."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import Verdict
from server.database import Database
from server.identity.models import Account
from server.queue import service as queue
from server.submissions import service as submissions
from server.submissions.models import State, Submission


@dataclass(frozen=True)
class Resource:
    """The JSON members of a submission (`api.schemas.SubmissionOut`)."""

    members: dict[str, Any]

    @property
    def done(self) -> bool:
        return bool(self.members["status"] == State.done)

    def text(self) -> str:
        return json.dumps(self.members, ensure_ascii=False, allow_nan=False)


def url_of(submission_id: UUID) -> str:
    return f"/api/v1/submissions/{submission_id}"


def resource(db: Session, submission: Submission) -> Resource:
    return Resource(
        {
            "id": str(submission.id),
            "status": submission.state,
            "position": queue.position(db, submission),
            "verdict": submission.verdict and Verdict.from_json(submission.verdict).to_json(),
            "url": url_of(submission.id),
            "exercise": submission.exercise,
            "created_at": submission.created_at.isoformat(),
        }
    )


def reader(database: Database, account: Account, submission_id: UUID) -> Callable[[], Resource]:
    """Reads the submission afresh, in a transaction of its own."""

    def read() -> Resource:
        with database.read() as db:
            return resource(db, submissions.get_for(db, account, submission_id))

    return read
