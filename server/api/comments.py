"""What is said of a submission: comments, questions, answers."""

from fastapi import APIRouter
from fastapi.exceptions import RequestValidationError

from server.api.comment_schemas import MessageOut, NewComment, ThreadChange, ThreadOut
from server.api.documentation import problem_responses
from server.base.app_services import SettingsOf
from server.base.errors import NotFound
from server.comments import service
from server.comments.line_tracking import LineRange
from server.comments.models import Thread, ThreadState
from server.comments.schemas import WHOLE_WORK, Conversation, ThreadTarget
from server.database.dependencies import Db
from server.gradebook import service as gradebook
from server.gradebook.schemas import Attempt
from server.identity.dependencies import ApiAccount
from server.identity.models import Account

router = APIRouter(tags=["comments"])


@router.get("/submissions/{submission_id}/comments", responses=problem_responses(401, 404))
def list_comments(submission_id: str, account: ApiAccount, db: Db) -> list[ThreadOut]:
    """What is said of a submission, of its author's earlier ones where that still stands, of the exercise."""
    attempt = gradebook.find_attempt(db, account, submission_id)
    return [_thread_out(talk, account) for talk in service.load_attempt_conversations(db, attempt)]


@router.post(
    "/submissions/{submission_id}/comments",
    status_code=201,
    responses=problem_responses(400, 401, 404, 409, 413, 422, 429),
)
def comment(submission_id: str, body: NewComment, account: ApiAccount, db: Db, settings: SettingsOf) -> ThreadOut:
    """Says something of a submission, or adds to a thread, which is open again if it was settled."""
    attempt = gradebook.find_attempt(db, account, submission_id)
    target = _thread_target(body)
    if body.thread is not None:
        thread = _require_thread_of_attempt(attempt, service.find_thread(db, account, body.thread))
        service.reply_to_thread(db, account, thread, body.text, settings)
    else:
        thread = service.begin_thread(db, account, attempt, target, body.text, settings)
    return _thread_out(service.load_conversation(db, thread), account)


@router.patch("/submissions/{submission_id}/comments/{thread_id}", responses=problem_responses(400, 401, 404, 413, 422))
def change(submission_id: str, thread_id: str, body: ThreadChange, account: ApiAccount, db: Db) -> ThreadOut:
    """Settles a thread, or opens it again."""
    attempt = gradebook.find_attempt(db, account, submission_id)
    thread = _require_thread_of_attempt(attempt, service.find_thread(db, account, thread_id))
    service.set_settled(thread, body.state == "settled")
    db.flush()
    return _thread_out(service.load_conversation(db, thread), account)


def _thread_target(body: NewComment) -> ThreadTarget:
    """At most one of what a comment may be about. Raises RequestValidationError."""
    given = [name for name in ("lines", "check", "thread") if getattr(body, name) is not None]
    if len(given) > 1:
        faults = [{"type": "extra_forbidden", "loc": ("body", name), "msg": ""} for name in given[1:]]
        raise RequestValidationError(faults)
    if body.lines is not None:
        return ThreadTarget(lines=LineRange(*body.lines))
    return WHOLE_WORK if body.check is None else ThreadTarget(check=body.check)


def _require_thread_of_attempt(attempt: Attempt, thread: Thread) -> Thread:
    """Raises NotFound for a thread on other work."""
    if (thread.account_id, thread.exercise) != (attempt.submission.account_id, attempt.submission.exercise):
        raise NotFound(service.UNKNOWN)
    return thread


def _thread_out(talk: Conversation, account: Account) -> ThreadOut:
    thread = talk.thread
    return ThreadOut(
        id=thread.id,
        submission=thread.submission_id,
        lines=None if talk.lines is None else [talk.lines.first, talk.lines.last],
        fate=talk.fate,
        check=thread.check_id,
        state=ThreadState(thread.state),
        created_at=thread.created_at,
        messages=[
            MessageOut(
                id=said.message.id,
                author=said.name,
                staff=said.message.as_staff,
                mine=said.message.author_id == account.id,
                text=said.text,
                created_at=said.message.created_at,
            )
            for said in talk.messages
        ],
    )
