"""A submission as the API shows it."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from uuid import UUID

from sqlalchemy.orm import Session

from server.base import root_path
from server.behaviour import service as behaviour
from server.database import Database
from server.gradebook import service as gradebook
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.submissions.models import SubmissionState
from server.submissions.service import GradingProgress, SubmissionService

#: What a client of the contract knows to wait on; that it was graded meanwhile, and how, is not told.
HELD = GradingProgress(SubmissionState.running)


@dataclass(frozen=True)
class SubmissionResource:
    """A submission as JSON (`api.schemas.SubmissionOut`), written in the thread that reads it: the loop passes it on.

    A verdict is what a student's program made of it, within `graders.core.contract.bounds`. `done`: nothing more is to
    be waited for here, as there is a verdict, or as a test holds it back; `settles_in`: seconds until that is so.
    """

    id: UUID
    done: bool
    held: bool
    text: str
    settles_in: float | None = field(default=None, compare=False)


def submission_url(submission_id: UUID) -> str:
    return f"/api/v1/submissions/{submission_id}"


def build_submission_resource(
    db: Session, store: SubmissionService, attempt: Attempt, *, placed: bool = True
) -> SubmissionResource:
    """With `placed`, what waits is told its place in the queue, which is a question more."""
    submission = attempt.submission
    place = (
        HELD if attempt.held else store.progress(db, submission) if placed else GradingProgress(SubmissionState.queued)
    )
    verdict = behaviour.load_visible_verdict(db, attempt)
    members = {
        "id": str(submission.id),
        "status": place.state,
        "position": place.position,
        "notice": attempt.held_text if attempt.held else place.notice,
        "held": attempt.held is not None,
        "load_error": attempt.load_error or None,
        "verdict": verdict.to_json() if verdict else None,
        "url": root_path.external_path(submission_url(submission.id)),
        "exercise": submission.exercise,
        "created_at": submission.created_at.isoformat(),
    }
    text = json.dumps(members, ensure_ascii=False, allow_nan=False)
    if attempt.held:
        return SubmissionResource(submission.id, not attempt.settles_in, True, text, attempt.settles_in)
    return SubmissionResource(submission.id, place.state == SubmissionState.done, False, text)


def make_resource_reader(
    database: Database, store: SubmissionService, account: Account, submission_id: UUID
) -> Callable[[], SubmissionResource]:
    """Reads the submission afresh, in a transaction of its own."""

    def read() -> SubmissionResource:
        with database.read() as db:
            return build_submission_resource(db, store, gradebook.find_attempt(db, account, submission_id))

    return read
