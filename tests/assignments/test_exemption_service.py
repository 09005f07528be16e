"""Exemptions follow who opens an account; what is wrong is told before anything is written."""

from __future__ import annotations

from datetime import timedelta

from server.assignments import editing, exemption_service, repository, student_assignments
from server.assignments.exemption_service import explain_rules
from server.assignments.models import WeightedExercise
from server.assignments.schemas import AssignmentInput, ExemptionInput, ExemptionTarget
from server.assignments.stages import AssignmentStage
from server.classes import repository as classes
from server.database import Database, utc_now
from server.identity.models import Account, Role
from server.personal.guest_adoption import adopt_guest_data
from tests.support.classes import new_class, seat
from tests.support.quick import the_course
from tests.support.service import new_account

DAY = timedelta(days=1)


def test_a_guest_s_exemption_follows_them_and_opens_earlier_for_them_alone(database: Database) -> None:
    teacher, guest, ada = (new_account(database, role, "x") for role in (Role.teacher, Role.guest, Role.student))
    made, now = new_class(database, teacher), utc_now()
    for one in (guest, new_account(database, Role.student, "Bob")):
        seat(database, made, one)
    wanted = AssignmentInput("DM", (WeightedExercise("l20/poses"),), now + 5 * DAY, now + 9 * DAY)
    early = ExemptionInput(opens_at=now - DAY, reason="part en stage")
    with database.write() as db:
        given = editing.create_assignment(db, the_course(), made, teacher.id, wanted)
        members = classes.load_members(db, made.id)
        exemption_service.grant_exemptions(db, made, teacher.id, given, members, ExemptionTarget((guest.id,)), early)
    with database.read() as db:
        bob = next(one for one in classes.load_members(db, made.id) if one.name == "Bob")
        assert student_assignments.load_open_assignments(db, bob.id, now) == []
        assert [
            one.stage for one in student_assignments.load_assignments_for_student(db, made.id, bob.id, (), now)
        ] == [AssignmentStage.upcoming]
    with database.write() as db:
        adopt_guest_data(db, guest.id, ada.id)
        db.delete(db.get_one(Account, guest.id))
    with database.read() as db:
        (found,) = student_assignments.load_open_assignments(db, ada.id, now)
        assert (found.stage, found.rules.due_at) == (AssignmentStage.open, wanted.due_at)
        told = explain_rules(found.rules, found.exemptions, ada.id)["opens_at"]
        assert [(one.origin, one.reason) for one in told] == [("student", "part en stage"), ("assignment", "")]
        assert [title for title, _ in repository.load_student_exemptions(db, ada.id, made.id)] == ["DM"]
        assert student_assignments.filter_due_soon([found], now, 2 * DAY) == []
        assert list(student_assignments.filter_due_soon([found], now, 9 * DAY)) == [found]
