"""An event keeps what has changed, and nothing that has not."""

from datetime import UTC, datetime

import pytest

from server.assignments.models import Assignment, AttemptSelection, Exemption, LatePolicy, Mode, Visibility
from server.audit import service as audit
from server.audit.models import ACTION_LABELS, AuditAction, AuditEvent
from server.audit.schemas import AuditFilter
from server.audit.wording import FIELDS, VALUES, describe_changes
from server.database import Database
from server.identity.models import Role
from tests.support.classes import new_class, seat
from tests.support.service import new_account


def test_only_what_differs_is_kept(database: Database) -> None:
    teacher = new_account(database, Role.teacher, "Mme Martin")
    made = new_class(database, teacher)
    due = datetime(2026, 3, 1, 8, tzinfo=UTC)
    with database.write() as db:
        before, after = {"title": "DM 1", "due_at": None}, {"title": "DM 1", "due_at": due}
        audit.record_event(
            db, made.id, teacher.id, AuditAction.assignment_changed, about="DM 1", before=before, after=after
        )
    with database.read() as db:
        (event,) = db.query(AuditEvent).all()
    assert (event.before, event.after) == ({"due_at": None}, {"due_at": "2026-03-01T08:00:00+00:00"})


def test_every_kind_of_change_has_its_words() -> None:
    assert set(ACTION_LABELS) == set(AuditAction)
    assert len(set(ACTION_LABELS.values())) == len(AuditAction)


def test_what_may_be_noted_has_its_words() -> None:
    columns = {one.name for table in (Assignment, Exemption) for one in table.__table__.columns}
    inner = {"id", "class_id", "assignment_id", "account_id", "created_by", "created_at", "revoked_at", "reason"}
    assert columns - inner <= set(FIELDS)
    for name, kind in {"mode": Mode, "late": LatePolicy, "counts": AttemptSelection, "hints": Visibility}.items():
        assert set(VALUES[name]) == set(kind)


def test_values_are_told_in_french() -> None:
    before = {"due_at": "2026-03-01T08:00:00+00:00", "points": 40 / 3, "excused": False, "late": "refuse"}
    after = {"due_at": None, "points": None, "excused": True, "exercises": {"l20/poses": 1.0}, "autre": ["x"]}
    told = [str(one) for one in describe_changes(before, after, lambda at: f"{at:%d/%m}")]
    assert told == [
        "à rendre le : 01/03 → rien", "points : 13,33 → rien", "dispense : non → oui", "retard : refusé",
        "exercices : l20/poses (1)", "autre : x",
    ]  # fmt: skip


def test_events_are_read_a_few_at_a_time_and_name_who_is_there(
    sqlite: Database, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(audit, "BATCH_SIZE", 2)
    teacher, ada = new_account(sqlite, Role.teacher, "Mme Martin"), new_account(sqlite)
    made = new_class(sqlite, teacher)
    seat(sqlite, made, ada, given_name="Ada", family_name="Lovelace")
    with sqlite.write() as db:
        for number in range(5):
            audit.record_event(
                db, made.id, teacher.id, AuditAction.mark_overridden, student=ada.id, about=f"n° {number}"
            )
        audit.record_event(db, made.id, teacher.id, AuditAction.exemption_made, about="DM", after={"label": "TP1"})
        audit.record_event(db, made.id, teacher.id, AuditAction.staff_changed)
    found = list(audit.iter_entries(sqlite, made.id, AuditFilter()))
    assert len({one.id for one in found}) == 7
    assert [one.at for one in found] == sorted((one.at for one in found), reverse=True)
    assert {one.student_name for one in found} == {"Ada Lovelace", ""}
    only = AuditFilter(student=ada.id, what=AuditAction.mark_overridden)
    assert len(list(audit.iter_entries(sqlite, made.id, only))) == 5
    with sqlite.write() as db:
        for account in (ada, teacher):
            db.delete(db.merge(account))
    assert {one.by_name for one in audit.iter_entries(sqlite, made.id, AuditFilter())} == {"compte effacé"}
    erased = {(one.what, one.student_name) for one in audit.iter_entries(sqlite, made.id, AuditFilter())}
    assert erased == {("mark_overridden", "compte effacé"), ("exemption_made", ""), ("staff_changed", "")}
