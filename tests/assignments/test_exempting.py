"""Exemptions follow who opens an account; what is wrong is told before anything is written."""

from __future__ import annotations

from datetime import timedelta

from server.assignments import exempting, keeping, mine, repository
from server.assignments.exempting import explained
from server.assignments.schemas import Wanted, WantedExemption, Weighted, Whom
from server.assignments.states import Stage
from server.classes import repository as classes
from server.database import Database, utc_now
from server.identity.models import Account, Role
from server.personal.joining import adopt
from tests.support.classes import new_class, seat
from tests.support.quick import the_course
from tests.support.service import new_account

DAY = timedelta(days=1)


def test_a_guest_s_exemption_follows_them_and_opens_earlier_for_them_alone(database: Database) -> None:
    teacher, guest, ada = (new_account(database, role, "x") for role in (Role.teacher, Role.guest, Role.student))
    made, now = new_class(database, teacher), utc_now()
    for one in (guest, new_account(database, Role.student, "Bob")):
        seat(database, made, one)
    wanted = Wanted("DM", (Weighted("l20/poses"),), now + 5 * DAY, now + 9 * DAY)
    early = WantedExemption(opens_at=now - DAY, reason="part en stage")
    with database.write() as db:
        given = keeping.make(db, the_course(), made, teacher.id, wanted)
        members = classes.members(db, made.id)
        exempting.grant(db, made, teacher.id, given, members, Whom((guest.id,)), early)
    with database.read() as db:
        bob = next(one for one in classes.members(db, made.id) if one.name == "Bob")
        assert mine.running(db, bob.id, now) == []
        assert [one.stage for one in mine.of_class(db, made.id, bob.id, (), now)] == [Stage.upcoming]
    with database.write() as db:
        adopt(db, guest.id, ada.id)
        db.delete(db.get_one(Account, guest.id))
    with database.read() as db:
        (found,) = mine.running(db, ada.id, now)
        assert (found.stage, found.rules.due_at) == (Stage.open, wanted.due_at)
        told = explained(found.rules, found.exemptions, ada.id)["opens_at"]
        assert [(one.origin, one.reason) for one in told] == [("student", "part en stage"), ("assignment", "")]
        assert [title for title, _ in repository.exemptions_of(db, ada.id, made.id)] == ["DM"]
        assert mine.due_within([found], now, 2 * DAY) == []
        assert list(mine.due_within([found], now, 9 * DAY)) == [found]
