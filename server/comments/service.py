"""Threads on a student's work: begin, answer, settle, and track to later attempts.

Every function works inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import Conflict, Invalid, NotFound
from server.base.settings import Settings
from server.base.validation import parse_uuid
from server.classes.models import SchoolClass
from server.classes.schemas import Member
from server.comments import notes_repository, readers_repository, repository
from server.comments.difference import diff_lines, split_lines
from server.comments.line_tracking import GONE, LineFate, LineRange, TrackedLines, track_lines
from server.comments.models import TITLE_LENGTH, Message, Thread, ThreadState
from server.comments.schemas import (
    AccountComments,
    Conversation,
    ThreadPage,
    ThreadSummary,
    ThreadTarget,
    UnreadThread,
    normalise_message_text,
)
from server.database import utc_now
from server.gradebook import service as gradebook
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.limits import service as limits
from server.rights import service as rights
from server.submissions.models import Submission

MAX_MESSAGES = 200
MAX_THREADS = 300
THREADS_PER_PAGE = 50
UNKNOWN = "Ce fil n’existe pas."
TOO_FAST = "Vous avez écrit beaucoup de messages en peu de temps : le prochain est possible dans {seconds} s."
NO_SUCH_LINE = "Cet essai a {count} lignes : indiquez une ligne de 1 à {count}, et une dernière qui ne la précède pas."
NO_SUCH_CHECK = "Le verdict de cet essai n’a pas cette vérification."
FULL_THREAD = f"Ce fil a déjà {MAX_MESSAGES} messages : commencez-en un autre."
FULL = f"Il y a déjà {MAX_THREADS} fils sur cet exercice : continuez l’un d’eux."
NOT_THE_AUTHOR = "Un autre élève a envoyé cet essai : posez votre question sur l’un des vôtres, ou sur l’exercice."
NOBODY = "Personne ne lirait votre question : rejoignez d’abord la classe de votre enseignant."


def find_thread(db: Session, account: Account | None, thread_id: UUID | str) -> Thread:
    """Return a thread that this account may read. Raises NotFound for any other, existing or not."""
    thread = repository.find_thread(db, parse_uuid(thread_id, UNKNOWN))
    if thread is None or not rights.may_read_work(db, account, thread.account_id, thread.exercise, thread.work_at):
        raise NotFound(UNKNOWN)
    return thread


def begin_thread(
    db: Session, by: Account, attempt: Attempt, target: ThreadTarget, text: str, settings: Settings
) -> Thread:
    """Begin a thread on an attempt that this account may read. Raises Invalid, Conflict or RateLimited.

    A student asks their teachers, and is refused without any.
    """
    submission = attempt.submission
    if attempt.shared:
        raise Conflict(NOT_THE_AUTHOR)
    message = normalise_message_text(text)
    thread = _build_thread(by, submission.account_id, submission.exercise, submission.created_at)
    thread.submission_id = submission.id
    if target.lines is not None:
        _require_lines_exist(submission, target.lines)
        thread.first_line, thread.last_line = target.lines.first, target.lines.last
    elif target.check is not None:
        thread.check_id, thread.check_title = target.check, _find_check_title(attempt, target.check)
    return _insert_thread(db, by, thread, message, settings)


def begin_exercise_thread(
    db: Session, by: Account, student: UUID, exercise: str, text: str, settings: Settings
) -> Thread:
    """Begin a thread on an exercise as a whole, with or as a student. Raises as `begin_thread`, and NotFound."""
    now = utc_now()
    if not rights.may_read_work(db, by, student, exercise, now):
        raise NotFound(UNKNOWN)
    return _insert_thread(db, by, _build_thread(by, student, exercise, now), normalise_message_text(text), settings)


def _build_thread(by: Account, student: UUID, exercise: str, work_at: datetime) -> Thread:
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


def _require_lines_exist(submission: Submission, lines: LineRange) -> None:
    count = len(split_lines(submission.code))
    if not 1 <= lines.first <= lines.last <= count:
        raise Invalid(NO_SUCH_LINE.format(count=count))


def _find_check_title(attempt: Attempt, check_id: str) -> str:
    checks = attempt.verdict.checks if attempt.verdict else ()
    titles = [check.title for check in checks if check.id == check_id]
    if not titles:
        raise Invalid(NO_SUCH_CHECK)
    return titles[0][:TITLE_LENGTH]


def _insert_thread(db: Session, by: Account, thread: Thread, text: str, settings: Settings) -> Thread:
    if not thread.by_staff and not rights.has_staff_readers(
        db, thread.account_id, rights.module_of_exercise(thread.exercise)
    ):
        raise Conflict(NOBODY)
    _take_comment_token(db, by, settings)
    if repository.count_threads(db, thread.account_id, thread.exercise) >= MAX_THREADS:
        raise Conflict(FULL)
    db.add(thread)
    db.flush()
    _add_message(db, by, thread, text)
    return thread


def reply_to_thread(db: Session, by: Account, thread: Thread, text: str, settings: Settings) -> Message:
    """Add a message to a thread, which reopens if it was settled. Raises Invalid, Conflict or RateLimited."""
    message = normalise_message_text(text)
    _take_comment_token(db, by, settings)
    repository.lock_thread(db, thread.id)
    if repository.count_messages(db, thread.id) >= MAX_MESSAGES:
        raise Conflict(FULL_THREAD)
    return _add_message(db, by, thread, message)


def _take_comment_token(db: Session, by: Account, settings: Settings) -> None:
    limits.take_token(db, f"comment:{by.id}", settings.comment_bucket, TOO_FAST)


def _add_message(db: Session, by: Account, thread: Thread, text: str) -> Message:
    as_staff, now = by.id != thread.account_id, utc_now()
    message = Message(thread_id=thread.id, author_id=by.id, as_staff=as_staff, text=text, created_at=now)
    db.add(message)
    thread.changed_at = now
    thread.state = ThreadState.answered if as_staff else ThreadState.open
    if as_staff:
        thread.staff_at = now
    db.flush()
    if not as_staff:
        readers_repository.mark_threads_seen(db, by.id, [thread.id], now)
    return message


def set_settled(thread: Thread, settled: bool) -> None:
    """Settle a thread, or restore the state that it had before."""
    if settled:
        thread.state = ThreadState.settled
    elif thread.state == ThreadState.settled:
        answered = thread.staff_at is not None and thread.staff_at >= thread.changed_at
        thread.state = ThreadState.answered if answered else ThreadState.open


def load_attempt_conversations(db: Session, attempt: Attempt, reader: UUID | None = None) -> Sequence[Conversation]:
    """Load the threads on an attempt, on the exercise, and on earlier attempts where they still apply, oldest first.

    `reader` is one of those who sent it, for whom threads may be new.
    """
    submission = attempt.submission
    threads = repository.load_threads_for_submission(db, submission)
    if attempt.shared:  # the rest is between its author and their teachers
        threads = [thread for thread in threads if thread.submission_id == submission.id]
    if not threads:
        return ()
    origins = _list_other_submissions(threads, submission.id)
    submissions = repository.load_submissions(db, origins) if origins else {}
    numbers = (
        repository.load_attempt_numbers(db, submission.account_id, submission.exercise, origins) if origins else {}
    )
    lines = split_lines(submission.code)
    diffs = {name: diff_lines(split_lines(earlier.code), lines) for name, earlier in submissions.items()}
    shown = [thread for thread in threads if thread.submission_id in {None, submission.id, *submissions}]
    messages = repository.load_messages(db, [thread.id for thread in shown])
    unread = _find_unread_threads(db, reader, shown)
    conversations = []
    for thread in reversed(shown):
        origin = thread.submission_id if thread.submission_id in submissions else None
        own_lines = _line_range_of_thread(thread)
        tracked = TrackedLines(LineFate.carried, own_lines)
        if origin is not None:
            tracked = track_lines(diffs[origin], own_lines) if own_lines else GONE
        number = None if origin is None else numbers.get(origin)
        is_new = thread.id in unread
        said = messages[thread.id]
        conversations.append(Conversation(thread, said, tracked.fate, tracked.lines, number, origin, is_new))
    return conversations


def _find_unread_threads(db: Session, reader: UUID | None, threads: Sequence[Thread]) -> frozenset[UUID]:
    """Return which threads are new to a reader; without any remark of the staff, no query is made."""
    remarks = [thread.id for thread in threads if thread.staff_at is not None]
    return frozenset() if reader is None or not remarks else readers_repository.filter_unread(db, reader, remarks)


def _list_other_submissions(threads: Sequence[Thread], current: UUID) -> list[UUID]:
    """Return the latest other attempts of these threads, a bounded number of them."""
    others = dict.fromkeys(thread.submission_id for thread in threads if thread.submission_id not in (None, current))
    return [submission_id for submission_id in others if submission_id is not None][: repository.MAX_TRACKED_ATTEMPTS]


def _line_range_of_thread(thread: Thread) -> LineRange | None:
    if thread.first_line is None or thread.last_line is None:
        return None
    return LineRange(thread.first_line, thread.last_line)


def load_exercise_conversations(
    db: Session, student: UUID, exercise: str, until: datetime | None = None
) -> Sequence[Conversation]:
    """Load the threads on a student's work in an exercise, newest first; `until` limits them to earlier work."""
    threads = repository.load_exercise_threads(db, student, exercise, until)
    messages = repository.load_messages(db, [thread.id for thread in threads]) if threads else {}
    origins = {thread.submission_id for thread in threads if thread.submission_id is not None}
    numbers = repository.load_attempt_numbers(db, student, exercise, origins) if origins else {}
    return [
        Conversation(
            thread,
            messages[thread.id],
            lines=_line_range_of_thread(thread),
            number=None if thread.submission_id is None else numbers.get(thread.submission_id),
            origin=thread.submission_id,
        )
        for thread in threads
    ]


def load_exercise_page_conversations(db: Session, student: Account, exercise: str) -> Sequence[Conversation]:
    """Load a student's threads on an exercise as a whole, and those on attempts that they have not read, oldest first.

    Those on what a partner sent for both are among the latter, where the student may see the attempt.
    """
    found = repository.load_exercise_page_threads(db, student.id, exercise)
    withheld = _find_withheld_submissions(db, student, found)
    threads = [thread for thread in found if thread.submission_id not in withheld]
    messages = repository.load_messages(db, [thread.id for thread in threads]) if threads else {}
    unread = _find_unread_threads(db, student.id, threads)
    return [Conversation(thread, messages[thread.id], is_new=thread.id in unread) for thread in threads]


def load_unread_threads(db: Session, student: Account) -> Sequence[UnreadThread]:
    """Load the threads that a student has not read, on their work and on their partners’, newest first."""
    rows = readers_repository.load_unread_threads(db, student.id)
    withheld = _find_withheld_submissions(db, student, [row.thread for row in rows])
    return [row for row in rows if row.thread.submission_id not in withheld]


def _find_withheld_submissions(db: Session, student: Account, threads: Iterable[Thread]) -> frozenset[UUID]:
    """Return the attempts of partners that the student may not see: a test withholds them. Asks for each once."""
    shared = {thread.submission_id for thread in threads if thread.account_id != student.id}
    return frozenset(
        attempt for attempt in shared if attempt is not None and not _may_see_attempt(db, student, attempt)
    )


def _may_see_attempt(db: Session, student: Account, attempt: UUID) -> bool:
    try:
        gradebook.find_attempt(db, student, attempt)
    except NotFound:
        return False
    return True


def mark_conversations_seen(db: Session, reader: UUID, conversations: Sequence[Conversation]) -> None:
    """Record that one of those who sent the work has looked at these threads."""
    readers_repository.mark_threads_seen(
        db, reader, [conversation.thread.id for conversation in conversations], utc_now()
    )


def load_conversation(db: Session, thread: Thread, reader: UUID | None = None) -> Conversation:
    """Load a thread with its messages; `reader` is one of those who sent the work, to whom it may be new."""
    said, unread = repository.load_messages(db, [thread.id])[thread.id], _find_unread_threads(db, reader, [thread])
    return Conversation(thread, said, lines=_line_range_of_thread(thread), is_new=thread.id in unread)


def count_open_questions(db: Session, student: UUID, until: datetime | None = None) -> Mapping[str, int]:
    """Count a student's open questions by exercise."""
    return repository.count_open_questions(db, student, until)


def load_thread_page(db: Session, school_class: SchoolClass, state: ThreadState | None, number: int) -> ThreadPage:
    """Load page `number`, from 1, of the threads of a class, in all states or in one."""
    offset = (number - 1) * THREADS_PER_PAGE
    rows = repository.load_class_threads(db, school_class, state, limit=THREADS_PER_PAGE + 1, offset=offset)
    threads = [
        ThreadSummary(thread, Member(membership, account).name, text or "", count)
        for thread, membership, account, text, count in rows[:THREADS_PER_PAGE]
    ]
    by_state = repository.count_class_threads(db, school_class)
    counts = {each: by_state.get(each, 0) for each in ThreadState}
    return ThreadPage(threads, counts, number, len(rows) > THREADS_PER_PAGE)


def load_account_comments(db: Session, account_id: UUID) -> AccountComments:
    """Load an account's threads, messages, phrases and notes."""
    threads = repository.load_account_threads(db, account_id)
    messages = repository.load_account_messages(db, account_id)
    return AccountComments(
        conversations=[
            Conversation(thread, messages.get(thread.id, ()), lines=_line_range_of_thread(thread)) for thread in threads
        ],
        seen=readers_repository.load_read_times(db, account_id),
        shared_readings=readers_repository.load_readings_of_others_threads(db, account_id),
        staff_messages=repository.load_staff_messages(db, account_id),
        phrases=notes_repository.load_all_phrases(db, account_id),
        received_notes=notes_repository.load_all_received_notes(db, account_id),
        sent_notes=notes_repository.load_sent_notes(db, account_id),
    )


def move_guest_threads(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move a guest's threads and notes to their account."""
    repository.move_threads(db, guest_id, account_id)
    readers_repository.move_thread_readings(db, guest_id, account_id)
    notes_repository.move_received_notes(db, guest_id, account_id)
