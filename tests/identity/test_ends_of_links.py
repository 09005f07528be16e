"""Links end with the reason for which they were made: the role of who they are for, the right of who made them."""

from __future__ import annotations

from collections.abc import Callable
from datetime import timedelta

import pytest
from sqlalchemy import select, update

from server.base.errors import Conflict, NotFound
from server.classes import service as classes
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.cli import main
from server.database import Database, utc_now
from server.identity import administration, links
from server.identity.models import Account, ApiToken, Invitation, PasswordLink, Role
from server.rights.slips import is_password_link_in_force
from tests.support.classes import new_class, person, seat
from tests.support.service import Site, new_account

NEW = "le lidar lit loin"


class Slip:
    """A slip that a teacher has made for a student of the list, in a class with a second teacher."""

    def __init__(self, database: Database) -> None:
        self.database = database
        self.teacher, self.other = (new_account(database, Role.teacher, name) for name in ("Mme Martin", "M. Roux"))
        self.made = new_class(database, self.teacher)
        seat(database, self.made, self.other, ClassRole.teacher)
        self.student = new_account(database)
        with database.write() as db:
            db.execute(update(Account).where(Account.id == self.student.id).values(login="ada"))
        seat(database, self.made, self.student, created_by_list=True)
        self.token = self.create()

    def create(self) -> str:
        with self.database.write() as db:
            account = db.get_one(Account, self.student.id)
            return links.create_password_link(
                db, account, timedelta(days=1), class_id=self.made.id, made_by=self.teacher.id
            )

    def opens(self) -> bool:
        with self.database.write() as db:
            try:
                links.find_link_owner(db, self.token, is_password_link_in_force)
            except NotFound:
                with pytest.raises(Conflict):
                    links.consume_password_link(db, self.token, is_password_link_in_force)
                return False
            return True

    def account(self, account: Account, **values: object) -> None:
        with self.database.write() as db:
            db.execute(update(Account).where(Account.id == account.id).values(**values))

    def member(self, account: Account, **values: object) -> None:
        with self.database.write() as db:
            db.execute(update(Membership).where(Membership.account_id == account.id).values(**values))


def _add_as_staff_elsewhere(slip: Slip) -> None:
    elsewhere = new_class(slip.database, slip.other, "PSI")
    seat(slip.database, elsewhere, slip.student, ClassRole.assistant)


def _archive(slip: Slip) -> None:
    with slip.database.write() as db:
        classes.archive_class(db.get_one(SchoolClass, slip.made.id))


def _remove_teacher(slip: Slip) -> None:
    with slip.database.write() as db:
        classes.remove_staff(db, db.get_one(SchoolClass, slip.made.id), slip.teacher.id)


def _erase_teacher(slip: Slip) -> None:
    with slip.database.write() as db:
        db.delete(db.get_one(Account, slip.teacher.id))


ENDS: dict[str, Callable[[Slip], None]] = {
    "the student has become a teacher": lambda slip: slip.account(slip.student, role=Role.teacher),
    "an administrator": lambda slip: slip.account(slip.student, role=Role.administrator),
    "teaches in this class": lambda slip: slip.member(slip.student, role=ClassRole.teacher),
    "assists in another one": _add_as_staff_elsewhere,
    "has left": lambda slip: slip.member(slip.student, status=Status.left),
    "asks to come back": lambda slip: slip.member(slip.student, status=Status.pending),
    "is disabled": lambda slip: slip.account(slip.student, disabled_at=utc_now()),
    "the teacher has left": _remove_teacher,
    "the teacher only assists": lambda slip: slip.member(slip.teacher, role=ClassRole.assistant),
    "the teacher is disabled": lambda slip: slip.account(slip.teacher, disabled_at=utc_now()),
    "the teacher is erased": _erase_teacher,
    "the class is archived": _archive,
}


@pytest.mark.parametrize("why", ENDS)
def test_a_slip_ends_with_its_reason(database: Database, why: str) -> None:
    slip = Slip(database)
    assert slip.opens()
    ENDS[why](slip)
    assert not slip.opens()


def test_a_slip_that_has_ended_does_not_come_back_with_the_role(sqlite: Database) -> None:
    slip = Slip(sqlite)
    with sqlite.write() as db:
        for role in (Role.teacher, Role.student):
            administration.change_role(db, db.get_one(Account, slip.student.id), role)
    assert not slip.opens()


def test_a_teacher_who_goes_on_keeps_the_slips_that_others_made_working(sqlite: Database) -> None:
    slip = Slip(sqlite)
    with sqlite.write() as db:
        classes.remove_staff(db, db.get_one(SchoolClass, slip.made.id), slip.other.id)
    assert slip.opens()


def test_who_becomes_staff_of_a_class_loses_links_and_tokens_made_before(site: Site) -> None:
    slip = Slip(site.database)
    token = person(site, account=slip.student).headers
    assert site.client.get("/api/v1/exercises", headers=token).status_code == 200
    elsewhere = new_class(site.database, slip.other, "PSI")
    with site.database.write() as db:
        classes.add_staff(db, db.get_one(SchoolClass, elsewhere.id), "ada", ClassRole.assistant)
    assert site.client.get("/api/v1/exercises", headers=token).status_code == 401
    with site.database.read() as db:
        assert db.execute(select(PasswordLink)).first() is None
        assert db.execute(select(ApiToken)).first() is None


def test_the_page_of_a_slip_that_has_ended_says_so_and_sets_no_password(site: Site) -> None:
    slip = Slip(site.database)
    path = f"/nouveau-mot-de-passe/{slip.token}"
    assert site.client.get(path).status_code == 200
    _remove_teacher(slip)
    for answer in (site.client.get(path), site.client.post(path, data={"new_password": NEW})):
        assert answer.status_code == 404
        assert "demandez-en un autre à votre enseignant" in answer.text
    with site.database.read() as db:
        assert db.get_one(Account, slip.student.id).password_hash is None


def test_slips_that_a_page_makes_end_with_the_right_of_their_maker(site: Site) -> None:
    teacher = person(site, Role.teacher, "Mme Martin")
    made = new_class(site.database, teacher.account)
    browser = teacher.browser(site)
    with site.database.write() as db:
        student = Account(role=Role.student, name="Ada", login="ada")
        db.add(student)
    seat(site.database, made, student, created_by_list=True)
    assert browser.post(f"/classes/{made.id}/acces").status_code == 200
    with site.database.read() as db:
        link = db.execute(select(PasswordLink)).scalar_one()
    assert (link.made_by, link.class_id, link.role) == (teacher.id, made.id, Role.student)


@pytest.mark.parametrize("how", ["create", "role"])
def test_the_first_administrator_s_link_ends_once_there_is_one(site: Site, how: str) -> None:
    with site.database.write() as db:
        token = links.create_administrator_invitation(db)
        db.add(Account(role=Role.student, name="Ada", login="ada"))
    assert site.client.get(f"/bienvenue/{token}").status_code == 200
    data = ["--data", str(site.settings.data_dir)]
    action = {"create": ["bob", "--name", "Bob", "--role", "administrator"], "role": ["ada", "administrator"]}[how]
    assert main(["admin", how, *action, *data]) == 0
    form = {"name": "Eve", "login": "eve", "password": NEW}
    assert site.client.get(f"/bienvenue/{token}").status_code == 404
    assert site.client.post(f"/bienvenue/{token}", data=form).status_code == 404


def test_an_invitation_that_ends_stays_valid_until_then(sqlite: Database) -> None:
    new_account(sqlite, Role.administrator)
    with sqlite.write() as db:
        token = links.create_invitation(db, Role.administrator, timedelta(days=1))
        assert links.find_open_invitation(db, token).role == Role.administrator
        db.execute(update(Invitation).values(expires_at=utc_now()))
        with pytest.raises(NotFound):
            links.find_open_invitation(db, token)


def test_a_link_of_an_administrator_has_no_class_and_ends_with_the_role_alone(sqlite: Database) -> None:
    ada = new_account(sqlite, Role.teacher)
    with sqlite.write() as db:
        token = links.create_password_link(db, db.get_one(Account, ada.id), timedelta(hours=1))
        assert links.find_link_owner(db, token, is_password_link_in_force).id == ada.id
        db.execute(update(Account).values(role=Role.administrator))
        with pytest.raises(NotFound):
            links.find_link_owner(db, token, is_password_link_in_force)
