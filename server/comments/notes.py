"""Kept phrases, and notes to all students who have a misconception now.

Every function works inside the caller's transaction.
"""

from __future__ import annotations

from collections.abc import Sequence
from uuid import UUID

from sqlalchemy.orm import Session

from server.assignments import feedback
from server.base.errors import Conflict, NotFound
from server.base.settings import Settings
from server.classes.models import SchoolClass
from server.classes.service import require_not_archived
from server.comments import notes_repository as repository
from server.comments.models import Note, Phrase
from server.comments.schemas import normalise_message_text
from server.comments.service import TOO_FAST
from server.database import utc_now
from server.identity.models import Account
from server.limits import service as limits

MAX_PHRASES = 200
MAX_SUGGESTED = 20
UNKNOWN_PHRASE = "Cette phrase n’est pas parmi celles que vous gardez."
UNKNOWN_NOTE = "Ce mot n’existe pas."
TOO_MANY_PHRASES = f"Vous gardez déjà {MAX_PHRASES} phrases : effacez-en d’abord."
NO_READERS = "Aucun élève de la classe n’a cette erreur en ce moment : le mot n’a pas été envoyé."
ALL_HELD = (
    "Ces élèves ne savent pas encore qu’ils ont cette erreur : un devoir retient ce diagnostic. Le mot n’a pas "
    "été envoyé ; il pourra l’être quand les résultats seront publiés."
)


def suggest_phrases(db: Session, by: Account, exercise: str, misconception: str | None) -> Sequence[Phrase]:
    """Return phrases to choose from: those kept for this misconception, then those for this exercise, then others."""
    return repository.load_ranked_phrases(db, by.id, exercise, misconception, MAX_SUGGESTED)


def save_phrase(db: Session, by: Account, text: str, exercise: str | None, misconception: str | None) -> Phrase:
    """Keep a phrase, unless the same text is kept already. Raises Invalid or Conflict."""
    text = normalise_message_text(text)
    existing = repository.find_phrase_by_text(db, by.id, text)
    if existing is not None:
        return existing
    if repository.count_phrases(db, by.id) >= MAX_PHRASES:
        raise Conflict(TOO_MANY_PHRASES)
    phrase = Phrase(account_id=by.id, text=text, exercise=exercise, misconception=misconception)
    db.add(phrase)
    db.flush()
    return phrase


def prepend_phrase(db: Session, by: Account, phrase_id: UUID | None, text: str) -> str:
    """Return a typed text after the chosen phrase, whose use is counted. Raises NotFound."""
    if phrase_id is None:
        return text
    phrase = repository.find_phrase(db, by.id, phrase_id)
    if phrase is None:
        raise NotFound(UNKNOWN_PHRASE)
    repository.increment_phrase_use(db, phrase.id)
    return f"{phrase.text}\n\n{text}" if text.strip() else phrase.text


def parse_phrase_id(text: str) -> UUID | None:
    """Parse a form's phrase id, empty where none is chosen. Raises NotFound."""
    try:
        return UUID(text) if text else None
    except ValueError as error:
        raise NotFound(UNKNOWN_PHRASE) from error


def delete_phrase(db: Session, by: Account, phrase_id: UUID) -> None:
    if not repository.delete_phrase(db, by.id, phrase_id):
        raise NotFound(UNKNOWN_PHRASE)


def send_note_to_students(
    db: Session,
    by: Account,
    school_class: SchoolClass,
    exercise: str,
    misconception: str | None,
    text: str,
    link: str,
    settings: Settings,
) -> tuple[Note, int]:
    """Send a note to the active students whose latest attempt has this misconception, or to all without one.

    Students whose diagnosis is held back are left out. Returns the note and the number of its readers. Raises Invalid,
    Conflict or RateLimited.
    """
    require_not_archived(school_class)
    text = normalise_message_text(text)
    limits.take_token(db, f"comment:{by.id}", settings.comment_bucket, TOO_FAST)
    students = repository.load_student_ids_with_misconception(db, school_class.id, exercise, misconception)
    readers = students if misconception is None else _exclude_withheld_accounts(db, students, exercise)
    if not readers:
        raise Conflict(ALL_HELD if students else NO_READERS)
    note = Note(
        class_id=school_class.id,
        exercise=exercise,
        misconception=misconception,
        text=text,
        link=link,
        account_id=by.id,
        created_at=utc_now(),
    )
    repository.insert_note(db, note, readers)
    return note, len(readers)


def _exclude_withheld_accounts(db: Session, accounts: Sequence[UUID], exercise: str) -> Sequence[UUID]:
    """Leave out the accounts whose diagnosis is held back: the note would reveal it."""
    holds = feedback.load_holds_by_student(db, accounts, exercise)
    return [account for account in accounts if account not in holds or holds[account].diagnosis is None]


def mark_note_read(db: Session, account: Account, note_id: UUID) -> None:
    """Record that an account has read a note. Raises NotFound."""
    if not repository.mark_note_read(db, note_id, account.id, utc_now()):
        raise NotFound(UNKNOWN_NOTE)
