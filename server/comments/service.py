"""Threads: saying something of a piece of work, answering, settling; what of it stands beside a later attempt.

Every function works inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import Conflict, Invalid, NotFound
from server.base.settings import Settings
from server.base.validation import parse_uuid
from server.classes.models import SchoolClass
from server.classes.schemas import Member
from server.comments import notes_repository, repository
from server.comments.difference import diff_lines, split_lines
from server.comments.line_tracking import GONE, LineFate, LineRange, TrackedLines, track_lines
from server.comments.models import TITLE_LENGTH, Message, Thread, ThreadState
from server.comments.schemas import (
    AccountComments,
    Conversation,
    ThreadPage,
    ThreadSummary,
    ThreadTarget,
    validate_text,
)
from server.database import utc_now
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.limits import service as limits
from server.rights import service as rights
from server.submissions.models import Submission

MAX_MESSAGES = 200
MAX_THREADS = 300
QUESTIONS_A_PAGE = 50
UNKNOWN = "Ce fil n’existe pas."
TOO_FAST = "Vous avez écrit beaucoup de messages en peu de temps : le prochain est possible dans {seconds} s."
NO_SUCH_LINE = "Cet essai a {count} lignes : indiquez une ligne de 1 à {count}, et une dernière qui ne la précède pas."
NO_SUCH_CHECK = "Le verdict de cet essai n’a pas cette vérification."
FULL_THREAD = f"Ce fil a déjà {MAX_MESSAGES} messages : commencez-en un autre."
FULL = f"Il y a déjà {MAX_THREADS} fils sur cet exercice : continuez l’un d’eux."
NOBODY = "Personne ne lirait votre question : rejoignez d’abord la classe de votre enseignant."


def find_thread(db: Session, account: Account | None, thread_id: UUID | str) -> Thread:
    """A thread that this account may read. Raises NotFound for any other, whatever exists."""
    thread = repository.find_thread(db, parse_uuid(thread_id, UNKNOWN))
    if thread is None or not rights.may_read_work(db, account, thread.account_id, thread.exercise, thread.work_at):
        raise NotFound(UNKNOWN)
    return thread


def begin_thread(
    db: Session, by: Account, attempt: Attempt, target: ThreadTarget, text: str, settings: Settings
) -> Thread:
    """Says something of an attempt that this account may read. Raises Invalid, Conflict or TooMany.

    Who has sent it asks those who teach them, and is refused where there is nobody.
    """
    submission = attempt.submission
    said = validate_text(text)
    thread = _thread(by, submission.account_id, submission.exercise, submission.created_at)
    thread.submission_id = submission.id
    if target.lines is not None:
        _require_lines(submission, target.lines)
        thread.first_line, thread.last_line = target.lines.first, target.lines.last
    elif target.check is not None:
        thread.check_id, thread.check_title = target.check, _title_of_check(attempt, target.check)
    return _begun(db, by, thread, said, settings)


def begin_exercise_thread(
    db: Session, by: Account, student: UUID, exercise: str, text: str, settings: Settings
) -> Thread:
    """Says something of an exercise as a whole, to or as a student of it. Raises as `begin` does, and NotFound."""
    now = utc_now()
    if not rights.may_read_work(db, by, student, exercise, now):
        raise NotFound(UNKNOWN)
    return _begun(db, by, _thread(by, student, exercise, now), validate_text(text), settings)


def _thread(by: Account, student: UUID, exercise: str, work_at: datetime) -> Thread:
    now = utc_now()
    return Thread(
        account_id=student,
        exercise=exercise,
        work_at=work_at,
        by_staff=by.id != student,
        check_title="",
        state=ThreadState.open,
        created_at=now,
    )


def _require_lines(submission: Submission, lines: LineRange) -> None:
    count = len(split_lines(submission.code))
    if not 1 <= lines.first <= lines.last <= count:
        raise Invalid(NO_SUCH_LINE.format(count=count))


def _title_of_check(attempt: Attempt, check_id: str) -> str:
    checks = attempt.verdict.checks if attempt.verdict else ()
    titles = [check.title for check in checks if check.id == check_id]
    if not titles:
        raise Invalid(NO_SUCH_CHECK)
    return titles[0][:TITLE_LENGTH]


def _begun(db: Session, by: Account, thread: Thread, text: str, settings: Settings) -> Thread:
    if not thread.by_staff and not rights.has_readers(db, thread.account_id, rights.module_of(thread.exercise)):
        raise Conflict(NOBODY)
    _take(db, by, settings)
    if repository.count_threads(db, thread.account_id, thread.exercise) >= MAX_THREADS:
        raise Conflict(FULL)
    db.add(thread)
    db.flush()
    _say(db, by, thread, text)
    return thread


def reply_to_thread(db: Session, by: Account, thread: Thread, text: str, settings: Settings) -> Message:
    """Adds to a thread, which is open again if it was settled: nothing that somebody wrote is lost.

    Raises Invalid, Conflict or TooMany.
    """
    said = validate_text(text)
    _take(db, by, settings)
    repository.lock_thread(db, thread.id)
    if repository.count_messages(db, thread.id) >= MAX_MESSAGES:
        raise Conflict(FULL_THREAD)
    return _say(db, by, thread, said)


def _take(db: Session, by: Account, settings: Settings) -> None:
    limits.take_token(db, f"comment:{by.id}", settings.comment_bucket, TOO_FAST)


def _say(db: Session, by: Account, thread: Thread, text: str) -> Message:
    as_staff, now = by.id != thread.account_id, utc_now()
    message = Message(thread_id=thread.id, author_id=by.id, as_staff=as_staff, text=text, created_at=now)
    db.add(message)
    thread.changed_at = now
    thread.state = ThreadState.answered if as_staff else ThreadState.open
    if as_staff:
        thread.staff_at = now
    else:
        thread.seen_at = now
    db.flush()
    return message


def set_settled(thread: Thread, settled: bool) -> None:
    """Says that there is no more to say, or that there is: it is then open again, or answered, as it was left."""
    if settled:
        thread.state = ThreadState.settled
    elif thread.state == ThreadState.settled:
        answered = thread.staff_at is not None and thread.staff_at >= thread.changed_at
        thread.state = ThreadState.answered if answered else ThreadState.open


def load_attempt_conversations(db: Session, attempt: Attempt) -> Sequence[Conversation]:
    """What is said of an attempt, of earlier ones where that still stands, and of the exercise: oldest first."""
    submission = attempt.submission
    threads = repository.load_threads_for_submission(db, submission)
    if not threads:
        return ()
    origins = _origins(threads, submission.id)
    sent = repository.load_submissions(db, origins) if origins else {}
    numbers = (
        repository.load_attempt_numbers(db, submission.account_id, submission.exercise, origins) if origins else {}
    )
    differences = {name: diff_lines(split_lines(one.code), split_lines(submission.code)) for name, one in sent.items()}
    shown = [one for one in threads if one.submission_id in (None, submission.id) or one.submission_id in sent]
    messages = repository.load_messages(db, [one.id for one in shown])
    talks = []
    for thread in reversed(shown):
        origin = thread.submission_id if thread.submission_id in sent else None
        lines = _lines(thread)
        carried = TrackedLines(LineFate.carried, lines)
        if origin is not None:
            carried = track_lines(differences[origin], lines) if lines else GONE
        number = None if origin is None else numbers.get(origin)
        talks.append(Conversation(thread, messages[thread.id], carried.fate, carried.lines, number, origin))
    return talks


def _origins(threads: Sequence[Thread], current: UUID) -> list[UUID]:
    """The latest of the other attempts that these threads are on: what is compared is bounded."""
    others = dict.fromkeys(one.submission_id for one in threads if one.submission_id not in (None, current))
    return [name for name in others if name is not None][: repository.MAX_TRACKED_ATTEMPTS]


def _lines(thread: Thread) -> LineRange | None:
    if thread.first_line is None or thread.last_line is None:
        return None
    return LineRange(thread.first_line, thread.last_line)


def load_exercise_conversations(
    db: Session, student: UUID, exercise: str, until: datetime | None = None
) -> Sequence[Conversation]:
    """Every thread on a student's work in an exercise, from before `until` where it is given, newest first."""
    threads = repository.load_exercise_threads(db, student, exercise, until)
    messages = repository.load_messages(db, [one.id for one in threads]) if threads else {}
    origins = {one.submission_id for one in threads if one.submission_id is not None}
    numbers = repository.load_attempt_numbers(db, student, exercise, origins) if origins else {}
    return [
        Conversation(
            one,
            messages[one.id],
            lines=_lines(one),
            number=None if one.submission_id is None else numbers.get(one.submission_id),
            origin=one.submission_id,
        )
        for one in threads
    ]


def load_page_conversations(db: Session, student: UUID, exercise: str) -> Sequence[Conversation]:
    """What is said of an exercise as a whole, to and by a student, and what they have not read, oldest first."""
    threads = repository.load_page_threads(db, student, exercise)
    messages = repository.load_messages(db, [one.id for one in threads]) if threads else {}
    return [Conversation(one, messages[one.id]) for one in threads]


def mark_seen(db: Session, talks: Sequence[Conversation]) -> None:
    """That the student has looked at these threads."""
    repository.mark_seen(db, [one.thread.id for one in talks], utc_now())


def load_conversation(db: Session, thread: Thread) -> Conversation:
    return Conversation(thread, repository.load_messages(db, [thread.id])[thread.id], lines=_lines(thread))


def count_open_questions(db: Session, student: UUID, until: datetime | None = None) -> Mapping[str, int]:
    """How many questions of a student wait for an answer, by exercise."""
    return repository.count_open_questions(db, student, until)


def load_thread_page(db: Session, school_class: SchoolClass, state: ThreadState | None, number: int) -> ThreadPage:
    """Page `number`, from 1, of what is said in a class; in one state alone where it is given."""
    skipped = (number - 1) * QUESTIONS_A_PAGE
    rows = repository.load_class_threads(db, school_class, state, most=QUESTIONS_A_PAGE + 1, skipped=skipped)
    lines = [
        ThreadSummary(thread, Member(membership, account).name, text or "", count)
        for thread, membership, account, text, count in rows[:QUESTIONS_A_PAGE]
    ]
    counted = repository.count_class_threads(db, school_class)
    counts = {one: counted.get(one, 0) for one in ThreadState}
    return ThreadPage(lines, counts, number, len(rows) > QUESTIONS_A_PAGE)


def load_account_comments(db: Session, account_id: UUID) -> AccountComments:
    """All that somebody has said and was told, and the phrases that they keep."""
    threads = repository.load_account_threads(db, account_id)
    messages = repository.load_account_messages(db, account_id)
    return AccountComments(
        conversations=[Conversation(one, messages.get(one.id, ()), lines=_lines(one)) for one in threads],
        staff_messages=repository.load_staff_messages(db, account_id),
        phrases=notes_repository.load_all_phrases(db, account_id),
        received_notes=notes_repository.load_all_received_notes(db, account_id),
        sent_notes=notes_repository.load_sent_notes(db, account_id),
    )


def adopt(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """What a guest has asked and was told is their account's."""
    repository.move_threads(db, guest_id, account_id)
    notes_repository.move_notes(db, guest_id, account_id)
