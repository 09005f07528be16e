"""Queue submissions again that lost their job, or whose grading ended as an internal error."""

from collections.abc import Collection
from uuid import UUID

from server.base.errors import NotFound
from server.database import Database
from server.gradebook import repository
from server.submissions import repository as stored
from server.submissions.service import UNKNOWN_SUBMISSION, SubmissionService, parse_submission_id

NOTHING_TO_DO = "L’essai {name} a son verdict : une recorrection, depuis la classe, le corrige à nouveau."


def requeue_for_grading(
    database: Database, submissions: SubmissionService, *, failed: bool, names: Collection[str] = ()
) -> list[UUID]:
    """Queue submissions that wait without a job, with `failed` also those with an internal error, or these alone.

    Each takes a transaction of its own. Failed gradings stay in the history. Return the ids; raise NotFound.
    """
    with database.read() as db:
        rows = (
            *stored.list_ungraded_submissions(db),
            *(repository.list_internal_error_submissions(db) if failed or names else ()),
        )
        grading_by_submission = {submission.id: submission.grading_id for submission in rows}
    wanted = list(map(parse_submission_id, names))
    for submission_id in sorted(set(wanted) - grading_by_submission.keys()):
        with database.read() as db:
            unknown = stored.find_submission(db, submission_id) is None
        raise NotFound(UNKNOWN_SUBMISSION if unknown else NOTHING_TO_DO.format(name=submission_id))
    return [
        submission_id
        for submission_id in wanted or grading_by_submission
        if _requeue_submission(database, submissions, submission_id, grading_by_submission[submission_id])
    ]


def _requeue_submission(
    database: Database, submissions: SubmissionService, submission_id: UUID, grading_id: UUID | None
) -> bool:
    """Return False where it has been graded meanwhile, is queued already, or is gone."""
    with database.write() as db:
        row = repository.load_submission_with_author(db, submission_id)
        return row is not None and row[0].grading_id == grading_id and submissions.requeue(db, *row)
