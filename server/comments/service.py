"""Threads: saying something of a piece of work, answering, settling; what of it stands beside a later attempt.

Every function works inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import Conflict, Invalid, NotFound
from server.base.identities import identity_of
from server.base.settings import Settings
from server.classes.models import SchoolClass
from server.classes.schemas import Member
from server.comments import repository, words_repository
from server.comments.carrying import GONE, Carried, Fate, Place, carry
from server.comments.difference import compare, lines_of
from server.comments.models import TITLE_LENGTH, Message, State, Thread
from server.comments.schemas import Own, Question, Questions, Talk, Target, text_of
from server.database import utc_now
from server.gradebook.schemas import Attempt
from server.identity.models import Account
from server.limits import service as limits
from server.rights import service as rights
from server.submissions.models import Submission

MOST_MESSAGES = 200
MOST_THREADS = 300
QUESTIONS_A_PAGE = 50
UNKNOWN = "Ce fil n’existe pas."
TOO_FAST = "Vous avez écrit beaucoup de messages en peu de temps : le prochain est possible dans {seconds} s."
NO_SUCH_LINE = "Cet essai a {count} lignes : indiquez une ligne de 1 à {count}, et une dernière qui ne la précède pas."
NO_SUCH_CHECK = "Le verdict de cet essai n’a pas cette vérification."
FULL_THREAD = f"Ce fil a déjà {MOST_MESSAGES} messages : commencez-en un autre."
FULL = f"Il y a déjà {MOST_THREADS} fils sur cet exercice : continuez l’un d’eux."
NOBODY = "Personne ne lirait votre question : rejoignez d’abord la classe de votre enseignant."


def find(db: Session, account: Account | None, thread_id: UUID | str) -> Thread:
    """A thread that this account may read. Raises NotFound for any other, whatever exists."""
    thread = repository.by_id(db, identity_of(thread_id, UNKNOWN))
    if thread is None or not rights.may_read_work(db, account, thread.account_id, thread.exercise, thread.work_at):
        raise NotFound(UNKNOWN)
    return thread


def begin(db: Session, by: Account, attempt: Attempt, target: Target, text: str, settings: Settings) -> Thread:
    """Says something of an attempt that this account may read. Raises Invalid, Conflict or TooMany.

    Who has sent it asks those who teach them, and is refused where there is nobody.
    """
    submission = attempt.submission
    said = text_of(text)
    thread = _thread(by, submission.account_id, submission.exercise, submission.created_at)
    thread.submission_id = submission.id
    if target.lines is not None:
        _require_lines(submission, target.lines)
        thread.first_line, thread.last_line = target.lines.first, target.lines.last
    elif target.check is not None:
        thread.check_id, thread.check_title = target.check, _title_of_check(attempt, target.check)
    return _begun(db, by, thread, said, settings)


def begin_whole(db: Session, by: Account, student: UUID, exercise: str, text: str, settings: Settings) -> Thread:
    """Says something of an exercise as a whole, to or as a student of it. Raises as `begin` does, and NotFound."""
    now = utc_now()
    if not rights.may_read_work(db, by, student, exercise, now):
        raise NotFound(UNKNOWN)
    return _begun(db, by, _thread(by, student, exercise, now), text_of(text), settings)


def _thread(by: Account, student: UUID, exercise: str, work_at: datetime) -> Thread:
    now = utc_now()
    return Thread(
        account_id=student,
        exercise=exercise,
        work_at=work_at,
        by_staff=by.id != student,
        check_title="",
        state=State.open,
        created_at=now,
    )


def _require_lines(submission: Submission, lines: Place) -> None:
    count = len(lines_of(submission.code))
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
    if repository.count_threads(db, thread.account_id, thread.exercise) >= MOST_THREADS:
        raise Conflict(FULL)
    db.add(thread)
    db.flush()
    _say(db, by, thread, text)
    return thread


def reply(db: Session, by: Account, thread: Thread, text: str, settings: Settings) -> Message:
    """Adds to a thread, which is open again if it was settled: nothing that somebody wrote is lost.

    Raises Invalid, Conflict or TooMany.
    """
    said = text_of(text)
    _take(db, by, settings)
    repository.locked(db, thread.id)
    if repository.count_messages(db, thread.id) >= MOST_MESSAGES:
        raise Conflict(FULL_THREAD)
    return _say(db, by, thread, said)


def _take(db: Session, by: Account, settings: Settings) -> None:
    limits.take(db, f"comment:{by.id}", settings.comment_bucket, TOO_FAST)


def _say(db: Session, by: Account, thread: Thread, text: str) -> Message:
    as_staff, now = by.id != thread.account_id, utc_now()
    message = Message(thread_id=thread.id, author_id=by.id, as_staff=as_staff, text=text, created_at=now)
    db.add(message)
    thread.changed_at = now
    thread.state = State.answered if as_staff else State.open
    if as_staff:
        thread.staff_at = now
    else:
        thread.seen_at = now
    db.flush()
    return message


def settle(thread: Thread, settled: bool) -> None:
    """Says that there is no more to say, or that there is: it is then open again, or answered, as it was left."""
    if settled:
        thread.state = State.settled
    elif thread.state == State.settled:
        answered = thread.staff_at is not None and thread.staff_at >= thread.changed_at
        thread.state = State.answered if answered else State.open


def beside(db: Session, attempt: Attempt) -> Sequence[Talk]:
    """What is said of an attempt, of earlier ones where that still stands, and of the exercise: oldest first."""
    submission = attempt.submission
    threads = repository.on(db, submission)
    if not threads:
        return ()
    origins = _origins(threads, submission.id)
    sent = repository.sources(db, origins) if origins else {}
    numbers = repository.numbers(db, submission.account_id, submission.exercise, origins) if origins else {}
    differences = {name: compare(lines_of(one.code), lines_of(submission.code)) for name, one in sent.items()}
    shown = [one for one in threads if one.submission_id in (None, submission.id) or one.submission_id in sent]
    messages = repository.messages_of(db, [one.id for one in shown])
    talks = []
    for thread in reversed(shown):
        origin = thread.submission_id if thread.submission_id in sent else None
        lines = _lines(thread)
        carried = Carried(Fate.carried, lines)
        if origin is not None:
            carried = carry(differences[origin], lines) if lines else GONE
        number = None if origin is None else numbers.get(origin)
        talks.append(Talk(thread, messages[thread.id], carried.fate, carried.place, number, origin))
    return talks


def _origins(threads: Sequence[Thread], current: UUID) -> list[UUID]:
    """The latest of the other attempts that these threads are on: what is compared is bounded."""
    others = dict.fromkeys(one.submission_id for one in threads if one.submission_id not in (None, current))
    return [name for name in others if name is not None][: repository.MOST_SOURCES]


def _lines(thread: Thread) -> Place | None:
    if thread.first_line is None or thread.last_line is None:
        return None
    return Place(thread.first_line, thread.last_line)


def of_exercise(db: Session, student: UUID, exercise: str, until: datetime | None = None) -> Sequence[Talk]:
    """Every thread on a student's work in an exercise, from before `until` where it is given, newest first."""
    threads = repository.of_exercise(db, student, exercise, until)
    messages = repository.messages_of(db, [one.id for one in threads]) if threads else {}
    origins = {one.submission_id for one in threads if one.submission_id is not None}
    numbers = repository.numbers(db, student, exercise, origins) if origins else {}
    return [
        Talk(
            one,
            messages[one.id],
            place=_lines(one),
            number=None if one.submission_id is None else numbers.get(one.submission_id),
            origin=one.submission_id,
        )
        for one in threads
    ]


def on_page(db: Session, student: UUID, exercise: str) -> Sequence[Talk]:
    """What is said of an exercise as a whole, to and by a student, and what they have not read, oldest first."""
    threads = repository.on_page(db, student, exercise)
    messages = repository.messages_of(db, [one.id for one in threads]) if threads else {}
    return [Talk(one, messages[one.id]) for one in threads]


def note_seen(db: Session, talks: Sequence[Talk]) -> None:
    """That the student has looked at these threads."""
    repository.note_seen(db, [one.thread.id for one in talks], utc_now())


def one(db: Session, thread: Thread) -> Talk:
    return Talk(thread, repository.messages_of(db, [thread.id])[thread.id], place=_lines(thread))


def asking(db: Session, student: UUID, until: datetime | None = None) -> Mapping[str, int]:
    """How many questions of a student wait for an answer, by exercise."""
    return repository.open_of(db, student, until)


def questions(db: Session, school_class: SchoolClass, state: State | None, number: int) -> Questions:
    """Page `number`, from 1, of what is said in a class; in one state alone where it is given."""
    skipped = (number - 1) * QUESTIONS_A_PAGE
    rows = repository.in_class(db, school_class, state, most=QUESTIONS_A_PAGE + 1, skipped=skipped)
    lines = [
        Question(thread, Member(membership, account).name, text or "", count)
        for thread, membership, account, text, count in rows[:QUESTIONS_A_PAGE]
    ]
    counted = repository.count_in_class(db, school_class)
    counts = {one: counted.get(one, 0) for one in State}
    return Questions(lines, counts, number, len(rows) > QUESTIONS_A_PAGE)


def own(db: Session, account_id: UUID) -> Own:
    """All that somebody has said and was told, and the phrases that they keep."""
    threads = repository.all_of(db, account_id)
    messages = repository.messages_of_account(db, account_id)
    return Own(
        talks=[Talk(one, messages.get(one.id, ()), place=_lines(one)) for one in threads],
        said=repository.said_as_staff(db, account_id),
        phrases=words_repository.all_phrases(db, account_id),
        words=words_repository.all_words(db, account_id),
        told=words_repository.told_by(db, account_id),
    )


def adopt(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """What a guest has asked and was told is their account's."""
    repository.move(db, guest_id, account_id)
    words_repository.move(db, guest_id, account_id)
