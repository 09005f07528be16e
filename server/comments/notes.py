"""What is said more than once: phrases that one keeps, a word to all who have a misconception now.

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
from server.classes.service import require_open
from server.comments import notes_repository as repository
from server.comments.models import Note, Phrase
from server.comments.schemas import validate_text
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
    "Qui a cette erreur ne le sait pas encore : un devoir retient ce diagnostic. Le mot n’a pas été envoyé ; il pourra "
    "l’être quand les résultats seront publiés."
)


def suggest_phrases(db: Session, by: Account, exercise: str, misconception: str | None) -> Sequence[Phrase]:
    """Phrases to choose from: first those kept for this misconception, then those for this exercise."""
    return repository.load_ranked_phrases(db, by.id, exercise, misconception, MAX_SUGGESTED)


def keep_phrase(db: Session, by: Account, text: str, exercise: str | None, misconception: str | None) -> Phrase:
    """Keeps a phrase; one that is kept already stays as it is. Raises Invalid or Conflict."""
    kept = validate_text(text)
    known = repository.find_phrase_by_text(db, by.id, kept)
    if known is not None:
        return known
    if repository.count_phrases(db, by.id) >= MAX_PHRASES:
        raise Conflict(TOO_MANY_PHRASES)
    phrase = Phrase(account_id=by.id, text=kept, exercise=exercise, misconception=misconception)
    db.add(phrase)
    db.flush()
    return phrase


def prepend_phrase(db: Session, by: Account, phrase_id: UUID | None, text: str) -> str:
    """What was typed, after the kept phrase that was chosen, which is used once more. Raises NotFound."""
    if phrase_id is None:
        return text
    phrase = repository.find_phrase(db, by.id, phrase_id)
    if phrase is None:
        raise NotFound(UNKNOWN_PHRASE)
    repository.count_phrase_use(db, phrase.id)
    return f"{phrase.text}\n\n{text}" if text.strip() else phrase.text


def parse_phrase_id(text: str) -> UUID | None:
    """A phrase's name as a form has it: none where none was chosen. Raises NotFound."""
    try:
        return UUID(text) if text else None
    except ValueError as error:
        raise NotFound(UNKNOWN_PHRASE) from error


def delete_phrase(db: Session, by: Account, phrase_id: UUID) -> None:
    if not repository.delete_phrase(db, by.id, phrase_id):
        raise NotFound(UNKNOWN_PHRASE)


def send_note(
    db: Session,
    by: Account,
    school_class: SchoolClass,
    exercise: str,
    misconception: str | None,
    text: str,
    link: str,
    settings: Settings,
) -> tuple[Note, int]:
    """A word to all active students of the class whose latest attempt has this misconception: how many they are.

    To all of them where no misconception is named. Whoever a test holds that attempt back from is not told of what is
    found of it. Raises Invalid, Conflict or TooMany.
    """
    require_open(school_class)
    said = validate_text(text)
    limits.take_token(db, f"comment:{by.id}", settings.comment_bucket, TOO_FAST)
    concerned = repository.load_student_ids_with_misconception(db, school_class.id, exercise, misconception)
    readers = concerned if misconception is None else _told(db, concerned, exercise)
    if not readers:
        raise Conflict(ALL_HELD if concerned else NO_READERS)
    note = Note(
        class_id=school_class.id,
        exercise=exercise,
        misconception=misconception,
        text=said,
        link=link,
        account_id=by.id,
        created_at=utc_now(),
    )
    repository.insert_note(db, note, readers)
    return note, len(readers)


def _told(db: Session, accounts: Sequence[UUID], exercise: str) -> Sequence[UUID]:
    """Those from whom no diagnosis is held back there: a word to all who share one would tell it."""
    held = feedback.load_holds_by_student(db, accounts, exercise)
    return [one for one in accounts if one not in held or held[one].diagnosis is None]


def mark_note_read(db: Session, account: Account, note_id: UUID) -> None:
    """Raises NotFound."""
    if not repository.mark_note_read(db, note_id, account.id, utc_now()):
        raise NotFound(UNKNOWN_NOTE)
