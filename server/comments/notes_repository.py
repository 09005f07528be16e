"""Queries on kept phrases and on notes to several students."""

from collections.abc import Collection, Sequence
from datetime import datetime
from uuid import UUID

from sqlalchemy import and_, case, delete, func, insert, select, update
from sqlalchemy.orm import Session

from server.classes.models import ClassRole, Membership, Status
from server.comments.models import Note, NoteReader, Phrase
from server.comments.schemas import ReceivedNote, SentNote
from server.database import table_of
from server.gradebook.models import Grading, Standing
from server.identity.models import Account
from server.submissions.models import Submission

MAX_RECEIVED_NOTES = 20
MAX_CLASS_NOTES = 100


def load_ranked_phrases(
    db: Session, account_id: UUID, exercise: str, misconception: str | None, limit: int
) -> Sequence[Phrase]:
    """Load an account's phrases: those for this misconception, then those for this exercise, then the most used."""
    misconception_rank = case((Phrase.misconception == misconception, 0), (Phrase.misconception.is_(None), 1), else_=2)
    exercise_rank = case((Phrase.exercise == exercise, 0), (Phrase.exercise.is_(None), 1), else_=2)
    query = select(Phrase).where(Phrase.account_id == account_id)
    query = query.order_by(misconception_rank, exercise_rank, Phrase.uses.desc(), Phrase.created_at.desc(), Phrase.id)
    return db.execute(query.limit(limit)).scalars().all()


def load_all_phrases(db: Session, account_id: UUID) -> Sequence[Phrase]:
    query = select(Phrase).where(Phrase.account_id == account_id)
    return db.execute(query.order_by(Phrase.created_at.desc(), Phrase.id)).scalars().all()


def find_phrase(db: Session, account_id: UUID, phrase_id: UUID) -> Phrase | None:
    return db.execute(
        select(Phrase).where(Phrase.id == phrase_id, Phrase.account_id == account_id)
    ).scalar_one_or_none()


def find_phrase_by_text(db: Session, account_id: UUID, text: str) -> Phrase | None:
    query = select(Phrase).where(Phrase.account_id == account_id, Phrase.text == text)
    return db.execute(query.limit(1)).scalar_one_or_none()


def count_phrases(db: Session, account_id: UUID) -> int:
    query = select(func.count()).select_from(Phrase).where(Phrase.account_id == account_id)
    return db.execute(query).scalar_one()


def increment_phrase_use(db: Session, phrase_id: UUID) -> None:
    db.execute(
        update(Phrase)
        .where(Phrase.id == phrase_id)
        .values(uses=Phrase.uses + 1)
        .execution_options(synchronize_session=False)
    )


def delete_phrase(db: Session, account_id: UUID, phrase_id: UUID) -> bool:
    statement = delete(Phrase).where(Phrase.id == phrase_id, Phrase.account_id == account_id).returning(Phrase.id)
    return db.execute(statement).first() is not None


def load_student_ids_with_misconception(
    db: Session, class_id: UUID, exercise: str, misconception: str | None
) -> Sequence[UUID]:
    """Load the active students whose latest attempt at the exercise has this misconception; all without one."""
    if misconception is not None and not misconception.isprintable():  # databases refuse a zero byte
        return ()
    query = select(Membership.account_id).where(
        Membership.class_id == class_id, Membership.role == ClassRole.student, Membership.status == Status.active
    )
    if misconception is not None:
        query = query.join(Standing, Standing.account_id == Membership.account_id)
        query = query.where(Standing.exercise == exercise, Standing.last_diagnosis == misconception)
    return db.execute(query).scalars().all()


def load_current_misconceptions(db: Session, class_id: UUID, exercise: str) -> Sequence[tuple[str, str, int]]:
    """Load the current misconceptions of a class in an exercise: id, title, number of active students."""
    title = func.max(Grading.verdict["diagnosis"]["title"].as_string())
    count = func.count(Standing.account_id.distinct())
    query = (
        select(Standing.last_diagnosis, title, count)
        .join(Membership, Membership.account_id == Standing.account_id)
        .join(Submission, and_(Submission.account_id == Standing.account_id, Submission.exercise == Standing.exercise))
        .join(Grading, and_(Grading.id == Submission.grading_id, Grading.diagnosis == Standing.last_diagnosis))
        .where(
            Membership.class_id == class_id,
            Membership.role == ClassRole.student,
            Membership.status == Status.active,
            Standing.exercise == exercise,
        )
        .group_by(Standing.last_diagnosis)
        .order_by(count.desc(), Standing.last_diagnosis)
    )
    return [(name, title or name, count) for name, title, count in db.execute(query) if name is not None]


def insert_note(db: Session, note: Note, readers: Collection[UUID]) -> None:
    db.add(note)
    db.flush()
    rows = [{"note_id": note.id, "account_id": reader, "seen_at": None} for reader in readers]
    db.execute(insert(table_of(NoteReader)), rows)


def load_received_notes(db: Session, account_id: UUID, exercise: str) -> Sequence[ReceivedNote]:
    """Load the notes on an exercise sent to an account, newest first."""
    query = (
        select(Note, Account.name, NoteReader.seen_at)
        .join(NoteReader, NoteReader.note_id == Note.id)
        .outerjoin(Account, Account.id == Note.account_id)
        .where(NoteReader.account_id == account_id, Note.exercise == exercise)
        .order_by(Note.created_at.desc(), Note.id)
        .limit(MAX_RECEIVED_NOTES)
    )
    return [ReceivedNote(note, name or "", seen_at) for note, name, seen_at in db.execute(query)]


def load_all_received_notes(db: Session, account_id: UUID) -> Sequence[ReceivedNote]:
    query = (
        select(Note, NoteReader.seen_at)
        .join(NoteReader, NoteReader.note_id == Note.id)
        .where(NoteReader.account_id == account_id)
        .order_by(Note.created_at, Note.id)
    )
    return [ReceivedNote(note, "", seen_at) for note, seen_at in db.execute(query)]


def mark_note_read(db: Session, note_id: UUID, account_id: UUID, now: datetime) -> bool:
    """Record that a reader has read a note; return False where there is none for them."""
    statement = (
        update(NoteReader)
        .where(NoteReader.note_id == note_id, NoteReader.account_id == account_id)
        .values(seen_at=func.coalesce(NoteReader.seen_at, now))
        .returning(NoteReader.note_id)
        .execution_options(synchronize_session=False)
    )
    return db.execute(statement).first() is not None


def load_class_notes(db: Session, class_id: UUID) -> Sequence[SentNote]:
    """Load the latest notes to a class, with their numbers of readers and of confirmed readers."""
    query = (
        select(Note, Account.name, func.count(NoteReader.account_id), func.count(NoteReader.seen_at))
        .outerjoin(NoteReader, NoteReader.note_id == Note.id)
        .outerjoin(Account, Account.id == Note.account_id)
        .where(Note.class_id == class_id)
        .group_by(Note.id, Account.name)
        .order_by(Note.created_at.desc(), Note.id)
    )
    rows = db.execute(query.limit(MAX_CLASS_NOTES))
    return [SentNote(note, name or "", readers, seen) for note, name, readers, seen in rows]


def load_sent_notes(db: Session, account_id: UUID) -> Sequence[Note]:
    query = select(Note).where(Note.account_id == account_id)
    return db.execute(query.order_by(Note.created_at, Note.id)).scalars().all()


def move_received_notes(db: Session, guest_id: UUID, account_id: UUID) -> None:
    """Move the notes for a guest to an account, except those that the account has already."""
    own = select(NoteReader.note_id).where(NoteReader.account_id == account_id)
    moved = update(NoteReader).where(NoteReader.account_id == guest_id, NoteReader.note_id.not_in(own))
    db.execute(moved.values(account_id=account_id).execution_options(synchronize_session=False))
