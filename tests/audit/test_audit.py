"""An event keeps what has changed, and nothing that has not."""

from datetime import UTC, datetime

from server.audit import service as audit
from server.audit.models import WORDS, AuditEvent, What
from server.database import Database
from server.identity.models import Role
from tests.support.classes import new_class
from tests.support.service import new_account


def test_only_what_differs_is_kept(database: Database) -> None:
    teacher = new_account(database, Role.teacher, "Mme Martin")
    made = new_class(database, teacher)
    due = datetime(2026, 3, 1, 8, tzinfo=UTC)
    with database.write() as db:
        before, after = {"title": "DM 1", "due_at": None}, {"title": "DM 1", "due_at": due}
        audit.note(db, made.id, teacher.id, What.assignment_changed, about="DM 1", before=before, after=after)
    with database.read() as db:
        (event,) = db.query(AuditEvent).all()
    assert (event.before, event.after) == ({"due_at": None}, {"due_at": "2026-03-01T08:00:00+00:00"})


def test_every_kind_of_change_has_its_words() -> None:
    assert set(WORDS) == set(What)
    assert len(set(WORDS.values())) == len(What)
