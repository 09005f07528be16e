"""Classes and their members: joining, leaving, lists, passwords; and what their teachers may read."""

from __future__ import annotations

from datetime import timedelta
from typing import Protocol
from uuid import UUID

import pytest

from server.base.errors import Conflict, Invalid, NotFound
from server.base.settings import Settings
from server.classes import copying, importing, repository, service, slips
from server.classes.importing import ImportPlan
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.classes.roster import read_roster
from server.classes.schemas import GuestName
from server.classes.service import ClassService
from server.database import Database, utc_now
from server.identity.models import Account, Role
from server.personal.guest_adoption import adopt_guest_data
from server.rights import service as rights
from tests.support.classes import new_class, seat
from tests.support.service import ADDRESS, EXERCISE, new_account


class Imported(Protocol):
    def __call__(self, text: str, *, replace: bool = False) -> ImportPlan: ...


@pytest.fixture
def teacher(sqlite: Database) -> Account:
    return new_account(sqlite, Role.teacher, "Mme Martin")


@pytest.fixture
def made(sqlite: Database, teacher: Account) -> SchoolClass:
    return new_class(sqlite, teacher)


@pytest.fixture
def classes(sqlite: Database, settings: Settings) -> ClassService:
    return ClassService(sqlite, settings)


@pytest.fixture
def imported(classes: ClassService, made: SchoolClass, teacher: Account) -> Imported:
    def write(text: str, *, replace: bool = False) -> ImportPlan:
        plan, written = classes.import_list(made.id, teacher, text.encode(), replace=replace)
        assert written
        return plan

    return write


def status(database: Database, made: SchoolClass, account: Account) -> str:
    with database.read() as db:
        return db.get_one(Membership, (made.id, account.id)).status


def names(database: Database, made: SchoolClass) -> dict[str, str]:
    with database.read() as db:
        found = repository.load_members(db, made.id)
        return {one.name: one.status.value for one in found if one.role is ClassRole.student}


def test_a_guest_joins_with_the_work_in_progress(sqlite: Database, classes: ClassService, made: SchoolClass) -> None:
    guest = new_account(sqlite, Role.guest, "Invité")
    with pytest.raises(Invalid, match="dit d’abord son nom"):
        classes.join_class(str(made.join_code), guest, address=ADDRESS)
    classes.join_class(str(made.join_code), guest, address=ADDRESS, named=GuestName("Ada", "Lovelace"))
    ada = new_account(sqlite, Role.student, "Ada L.")
    with sqlite.write() as db:
        assert db.get_one(Account, guest.id).name == "Ada Lovelace"
        adopt_guest_data(db, guest.id, ada.id)
    with sqlite.read() as db:
        (member,) = [one for one in repository.load_members(db, made.id) if one.role is ClassRole.student]
    assert (member.id, member.name) == (ada.id, "Ada Lovelace")


def test_a_guest_who_is_in_the_class_twice_is_in_it_once(
    sqlite: Database, classes: ClassService, made: SchoolClass
) -> None:
    guest, ada = new_account(sqlite, Role.guest), new_account(sqlite)
    classes.join_class(str(made.join_code), guest, address=ADDRESS, named=GuestName("Ada", "L"))
    seat(sqlite, made, ada, status=Status.left)
    with sqlite.write() as db:
        adopt_guest_data(db, guest.id, ada.id)
    assert status(sqlite, made, ada) == Status.active
    assert len(names(sqlite, made)) == 1


def test_who_asks_is_let_in_or_not_by_a_teacher(sqlite: Database, classes: ClassService, made: SchoolClass) -> None:
    with sqlite.write() as db:
        db.get_one(SchoolClass, made.id).approval = True
    ada, bob = new_account(sqlite), new_account(sqlite)
    for one in (ada, bob):
        classes.join_class(str(made.join_code), one, address=ADDRESS)
        assert status(sqlite, made, one) == Status.pending
    with sqlite.write() as db:
        school_class = db.get_one(SchoolClass, made.id)
        assert service.apply_action_to_students(db, school_class, [ada.id], "accept") == 1
        assert service.apply_action_to_students(db, school_class, [bob.id], "refuse") == 1
        assert service.apply_action_to_students(db, school_class, [ada.id, bob.id], "accept") == 0
    assert (status(sqlite, made, ada), status(sqlite, made, bob)) == (Status.active, Status.left)


def test_who_went_comes_back_by_the_code_alone(
    sqlite: Database, classes: ClassService, made: SchoolClass, imported: Imported
) -> None:
    """Or a teacher of once would go on reading what they do."""
    ada = new_account(sqlite, name="Ada Lovelace")
    classes.join_class(str(made.join_code), ada, address=ADDRESS)
    imported("nom,prenom,identifiant\nTuring,Alan,alan\nLovelace,Ada,\n")
    with sqlite.write() as db:
        school_class = db.get_one(SchoolClass, made.id)
        alan = next(one.id for one in repository.load_members(db, made.id) if one.account.login == "alan")
        for one in (ada.id, alan):
            service.leave_class(db, school_class, one)
        with pytest.raises(Conflict, match="d’elle-même"):
            service.apply_action_to_students(db, school_class, [ada.id], "take_back")
    plan = imported("nom,prenom,identifiant\nTuring,Alan,alan\nLovelace,Ada,\n")
    assert ([one.line for one in plan.rejected], len(plan.updated)) == ([3], 1), "the list's own accounts are its own"
    assert names(sqlite, made) == {"Ada Lovelace": "left", "Alan Turing": "active"}
    classes.join_class(str(made.join_code), ada, address=ADDRESS)
    assert imported("nom,prenom\nLovelace,Ada\n").rejected == ()


def test_a_class_keeps_a_teacher(sqlite: Database, made: SchoolClass, teacher: Account) -> None:
    with sqlite.write() as db:
        db.add(Account(role=Role.teacher, name="M. Durand", login="durand"))
    for _ in range(2):
        with sqlite.write() as db, pytest.raises(Conflict):
            service.leave_class(db, db.get_one(SchoolClass, made.id), teacher.id)
    with sqlite.write() as db:
        school_class = db.get_one(SchoolClass, made.id)
        durand = service.add_staff(db, school_class, " Durand ", ClassRole.teacher)
        service.leave_class(db, school_class, teacher.id)
        with pytest.raises(Conflict):
            service.remove_staff(db, school_class, durand.id)
        with pytest.raises(Conflict):
            service.add_staff(db, school_class, "durand", ClassRole.assistant)
        with pytest.raises(NotFound):
            service.remove_staff(db, school_class, teacher.id)


def test_an_archived_class_is_joined_by_nobody_and_changes_no_more(
    sqlite: Database, classes: ClassService, made: SchoolClass, teacher: Account
) -> None:
    with sqlite.write() as db:
        service.archive_class(db.get_one(SchoolClass, made.id))
    with pytest.raises(NotFound):
        classes.join_class(str(made.join_code), new_account(sqlite), address=ADDRESS)
    with pytest.raises(Conflict):
        classes.import_list(made.id, teacher, b"nom\nA\n")
    with sqlite.write() as db:
        school_class = db.get_one(SchoolClass, made.id)
        with pytest.raises(Conflict):
            service.renew_join_code(db, school_class, "jour")
        service.reopen_class(school_class)
        service.renew_join_code(db, school_class, "jour")
        code = str(school_class.join_code)
    assert classes.join_class(code, new_account(sqlite), address=ADDRESS).school_class.id == made.id


def test_a_copy_has_the_teachers_and_none_of_the_students(
    sqlite: Database, made: SchoolClass, teacher: Account
) -> None:
    helper = seat(sqlite, made, new_account(sqlite), ClassRole.assistant)
    seat(sqlite, made, new_account(sqlite))
    with sqlite.write() as db:
        copied = copying.copy_class(db, db.get_one(SchoolClass, made.id), teacher, "MPSI 2 (2027)", module=made.module)
        seats = {one.id: one.role for one in repository.load_members(db, copied.id)}
    assert seats == {teacher.id: ClassRole.teacher, helper.id: ClassRole.assistant}
    assert (copied.module, copied.approval) == (made.module, made.approval)
    assert copied.join_code not in {None, made.join_code}


def test_a_copy_may_take_along_the_students_of_today(sqlite: Database, made: SchoolClass, teacher: Account) -> None:
    ada = seat(sqlite, made, new_account(sqlite), family_name="LOVELACE", given_name="Ada", groups=["TP1"])
    seat(sqlite, made, new_account(sqlite), status=Status.left)
    seat(sqlite, made, new_account(sqlite), status=Status.pending)
    with sqlite.write() as db:
        original = db.get_one(SchoolClass, made.id)
        copied = copying.copy_class(db, original, teacher, "MPSI 2", module="l20e2", with_students=True)
        there = {one.id: one.membership for one in repository.load_members(db, copied.id)}
    assert copied.module == "l20e2"
    assert set(there) == {teacher.id, ada.id}
    assert (there[ada.id].family_name, there[ada.id].groups) == ("LOVELACE", ["TP1"])


def test_members_are_known_by_login_then_address_then_name(
    sqlite: Database, classes: ClassService, made: SchoolClass, imported: Imported
) -> None:
    joined = new_account(sqlite, name="Alan Turing")
    classes.join_class(str(made.join_code), joined, address=ADDRESS)
    first = imported("nom;prenom;email;identifiant\nLOVELACE;Ada;ada@x.fr;ada\nTURING;Alan;;\nNoether;Emmy;e@x.fr;\n")
    assert (len(first.added), len(first.updated), first.left, first.rejected) == (2, 1, (), ())
    second = imported("prenom,nom,email\nAda,Byron,ada@x.fr\nAlan,Turing,\nEmmy,Noether,\n")
    assert (len(second.added), len(second.updated), len(second.left)) == (0, 2, 0)
    assert names(sqlite, made) == dict.fromkeys(["Ada Byron", "Alan Turing", "Emmy Noether"], "active")


def test_where_it_may_be_somebody_else_the_line_is_rejected_and_nobody_leaves(
    sqlite: Database, made: SchoolClass, imported: Imported
) -> None:
    imported("nom;prenom;identifiant;email\nMartin;Paul;pm1;\nMartin;Paul;pm2;\nLovelace;Ada;ada;\nTuring;Alan;at;\n")
    plan = imported(
        "nom;prenom;identifiant;email\nMartin;Paul;;\nLovelace;Ada;autre;\nTuring;Alan;;pas bon\nNew;One;;\n",
        replace=True,
    )
    assert [(one.line, one.reason[:12]) for one in plan.rejected] == [
        (2, "plusieurs me"),
        (3, "un membre de"),
        (4, "« pas bon » "),
    ]
    assert plan.left == ()
    assert len(names(sqlite, made)) == 5
    assert set(names(sqlite, made).values()) == {"active"}


def test_logins_are_made_of_names_and_free(sqlite: Database, made: SchoolClass, imported: Imported) -> None:
    with sqlite.write() as db:
        db.add(Account(name="x", login="zoe.ecole-elu"))
    imported("nom,prenom\nÉcole Élu,Zoé\nX,\n李,\n")
    with sqlite.read() as db:
        logins = [one.account.login for one in repository.load_members(db, made.id) if one.role is ClassRole.student]
    assert sorted(map(str, logins)) == ["eleve.x", "eleve.李", "zoe.ecole-elu2"]


def test_what_was_shown_is_what_is_written(
    sqlite: Database, classes: ClassService, made: SchoolClass, teacher: Account
) -> None:
    content = b"nom,prenom\nLovelace,Ada\n,,\nbad,\x00\n"
    with pytest.raises(Invalid):
        classes.preview_import(made, teacher, content)
    content = b"nom,prenom,email\n\nLovelace,Ada,zut\nTuring,Alan,\n"
    shown, text = classes.preview_import(made, teacher, content, replace=True)
    seat(sqlite, made, new_account(sqlite, name="Grace Hopper"))
    again, written = classes.import_list(made.id, teacher, text.encode(), expected=shown.digest, replace=True)
    assert not written
    assert [one.name for one in again.left] == ["Grace Hopper"]
    assert names(sqlite, made) == {"Grace Hopper": "active"}
    carried = text.replace("\n", "\r\n").encode()  # as a browser sends it
    final, written = classes.import_list(made.id, teacher, carried, expected=again.digest, replace=True)
    assert (written, final.rejected, again.rejected[0].line) == (True, again.rejected, 3)
    assert names(sqlite, made) == {"Grace Hopper": "left", "Alan Turing": "active"}


def test_passwords_are_handed_over_for_those_whom_the_list_has_made_alone(
    sqlite: Database,
    classes: ClassService,
    made: SchoolClass,
    imported: Imported,
    settings: Settings,
    teacher: Account,
) -> None:
    own = new_account(sqlite, name="Own Account")
    classes.join_class(str(made.join_code), own, address=ADDRESS)
    imported("nom,identifiant\nOwn Account,\nLovelace,ada\nTuring,alan\nHopper,grace\n")
    with sqlite.write() as db:
        ids = {one.account.login: one.id for one in repository.load_members(db, made.id) if one.account.login}
        db.get_one(Account, ids["alan"]).password_hash = "x"
        db.get_one(Account, ids["grace"]).role = Role.teacher
        school_class = db.get_one(SchoolClass, made.id)
        given, refused = slips.create_password_slips(db, school_class, None, settings, made_by=teacher.id)
        assert ([one.login for one in given], refused) == (["ada"], [])
        chosen: list[UUID] = [ids["alan"], ids["grace"], own.id]
        given, refused = slips.create_password_slips(db, school_class, chosen, settings, made_by=teacher.id)
        assert ([one.login for one in given], len(refused)) == (["alan"], 2)


def test_a_teacher_reads_what_was_sent_to_the_module_while_one_was_in_the_class(
    sqlite: Database, made: SchoolClass, teacher: Account
) -> None:
    now = utc_now()
    ada, helper = new_account(sqlite), seat(sqlite, made, new_account(sqlite), ClassRole.assistant)
    bob = seat(sqlite, made, new_account(sqlite))

    def reads(reader: Account, sent_after: float = 0, exercise: str = EXERCISE) -> bool:
        with sqlite.read() as db:
            return rights.may_read_work(db, reader, ada.id, exercise, now + timedelta(hours=sent_after))

    assert not reads(teacher)
    seat(sqlite, made, ada, status=Status.pending)
    assert not reads(teacher)
    seat(sqlite, made, ada)
    assert reads(teacher)
    assert reads(helper)
    assert not reads(bob)
    assert not reads(teacher, exercise="l99/autre")
    assert reads(teacher, -1000), "what was sent before one joined follows one into the class"
    seat(sqlite, made, ada, status=Status.left, left_at=now)
    assert (reads(teacher, -1), reads(teacher, 1)) == (True, False)
    seat(sqlite, made, ada, status=Status.left)
    assert not reads(teacher, -1), "who was refused was never in it"
    seat(sqlite, made, ada)
    with sqlite.write() as db:
        db.get_one(SchoolClass, made.id).archived_at = now
    assert (reads(teacher, -1), reads(teacher, 1)) == (True, False)
    assert reads(new_account(sqlite, Role.administrator), 1)


def test_planning_writes_nothing(sqlite: Database, made: SchoolClass, teacher: Account) -> None:
    with sqlite.read() as db:
        importing.plan_import(db, made, read_roster(b"nom\nLovelace\n"), teacher)
        assert not db.new
        assert not db.dirty


def test_a_list_is_sorted_as_it_is_read_aloud(database: Database) -> None:
    made = new_class(database, new_account(database, Role.teacher))
    for family in ("Zola", "Éluard", "Dumas", "aragon"):
        seat(database, made, new_account(database), family_name=family, given_name="X")
    with database.read() as db:
        names = [
            one.membership.family_name for one in repository.load_members(db, made.id) if one.membership.family_name
        ]
    assert names == ["aragon", "Dumas", "Éluard", "Zola"]


def test_namesakes_are_told_apart_wherever_their_names_stand(
    sqlite: Database, classes: ClassService, made: SchoolClass, imported: Imported
) -> None:
    listed = "nom;prenom;né le;groupe\nLacroix;Inès;1/2/2008;TP1\nLACROIX;Ines;3/4/2008;TP2\nPetit;Ana;;\n"
    imported(listed)
    guest = new_account(sqlite, Role.guest, "Invité")
    classes.join_class(str(made.join_code), guest, address=ADDRESS, named=GuestName("Ana", "Petit"))
    shown = [
        "Ana Petit (ana.petit)", "Ana Petit (invité)", "Ines LACROIX (ines.lacroix2)", "Inès Lacroix (ines.lacroix)",
    ]  # fmt: skip
    with sqlite.read() as db:
        members = [member for member in repository.load_members(db, made.id) if member.role is ClassRole.student]
        assert sorted(member.name for member in members) == shown
        assert sorted(student.name for student in repository.load_active_students(db, made.id)) == shown
        assert sorted(student.name for student in repository.load_student_records(db, made.id)) == shown
    again = imported(listed)
    assert (len(again.unchanged), [line.line for line in again.rejected]) == (2, [4])
