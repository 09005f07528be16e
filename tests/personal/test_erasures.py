"""Erasure on request: what goes and what stays, who may, what the log says, and that no clock begins anew."""

from __future__ import annotations

import io
import json
import re
import threading
import zipfile
from dataclasses import dataclass
from datetime import timedelta
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import func, inspect, select, update

from server.app import ApplicationServices
from server.assignments import eligibility, sittings
from server.assignments.models import Assignment, Exemption, Mode, SavedWork, Sitting
from server.audit.models import AuditAction, AuditEvent
from server.base.errors import Forbidden, WrongMoment
from server.base.settings import Settings
from server.classes.models import ClassRole, Membership, SchoolClass
from server.cli import main
from server.database import Database, utc_now
from server.identity.models import Account, Role
from server.marks.models import ManualColumn, ManualMark, Override
from server.personal import erasure_repository as repository
from server.personal import erasures
from server.personal.models import ErasureRequest
from server.personal.service import PersonalDataService
from server.submissions.models import Submission
from server.tables import metadata
from tests.support.classes import Person, assign, new_class, person, seat
from tests.support.client import TestClient
from tests.support.service import EXERCISE, Site, new_account

FORM = {"name": "Ada Lovelace", "login": "ada", "password": "notes sur la machine"}


@dataclass
class School:
    """A class with its teacher, a test that is open, and Ada, who has signed up and joined by the code."""

    site: Site
    teacher: Person
    made: SchoolClass
    test: Assignment
    ada: TestClient

    @property
    def path(self) -> str:
        return f"/classes/{self.made.id}/devoirs/{self.test.id}"

    @property
    def ada_id(self) -> UUID | None:
        with self.site.database.read() as db:
            return db.execute(select(Account.id).where(Account.login == "ada")).scalar_one_or_none()

    @property
    def page(self) -> str:
        return f"/classes/{self.made.id}/eleves/{self.ada_id}/effacer"

    def begin(self) -> int:
        status: int = self.ada.post(f"{self.path}/commencer").status_code
        return status

    def erase_self(self) -> Any:
        return self.ada.post("/compte/supprimer", data={"password": FORM["password"]})

    def erase(self, by: Person | None = None) -> Any:
        browser = (by or self.teacher).browser(self.site)
        page = browser.get(self.page)
        found = re.search(r'name="attendu" value="(\w+)"', page.text)
        assert found, page.text
        return browser.post(self.page, data={"action": "effacer", "attendu": found[1]})

    def publish(self) -> None:
        assert self.teacher.browser(self.site).post(f"{self.path}/publier").status_code == 303

    def tidy(self) -> None:
        ApplicationServices(self.site.settings, None, ()).delete_expired_data()  # type: ignore[arg-type]

    def events(self) -> list[tuple[str, UUID | None, UUID | None]]:
        with self.site.database.read() as db:
            rows = db.execute(select(AuditEvent).order_by(AuditEvent.at, AuditEvent.id)).scalars()
            return [(event.what, event.by, event.student) for event in rows if event.what in ERASURES]


ERASURES = {AuditAction.erasure_requested, AuditAction.erasure_cancelled, AuditAction.student_erased}


@pytest.fixture
def school(site: Site) -> School:
    teacher = person(site, Role.teacher, "Mme Martin")
    made = new_class(site.database, teacher.account)
    test = assign(site.database, made, EXERCISE, mode=Mode.test, duration_minutes=60)
    ada = TestClient(site.app, follow_redirects=False)
    ada.post("/inscription", data=FORM)
    assert ada.post(f"/rejoindre/{made.join_code}").status_code == 303
    return School(site, teacher, made, test, ada)


def told(answer: Any) -> str:
    return re.sub(r"\s+", " ", re.sub(r"<[^>]*>", " ", answer.text)).replace("\u00a0", " ")


def test_who_sits_a_test_is_erased_when_it_is_published_and_told_so(school: School) -> None:
    assert school.begin() == 303
    school.ada.post("/l20/exercices/poses/soumissions", data={"code": "x = 1"})
    assert "sera effacé à leur publication" in told(school.ada.get("/compte/supprimer"))
    assert school.erase_self().headers["location"] == "/compte/supprimer"
    page = told(school.ada.get("/compte/supprimer"))
    assert "Vous avez demandé l’effacement" in page
    assert "Interro" in page
    assert "L’effacement de votre compte est demandé" in told(school.ada.get("/compte"))
    assert school.begin() == 303, "they may go on"
    with zipfile.ZipFile(io.BytesIO(school.ada.get("/compte/donnees").content)) as files:
        (request,) = json.loads(files.read("compte.json"))["erasure_requests"]
    assert request["by_staff"] is False
    school.tidy()
    with school.site.database.read() as db:
        assert db.execute(select(func.count()).select_from(Sitting)).scalar_one() == 1
        assert db.execute(select(func.count()).select_from(Submission)).scalar_one() == 1
    school.ada.post(f"{school.path}/rendre")
    school.publish()
    assert school.ada_id is not None
    school.tidy()
    assert school.ada_id is None
    with school.site.database.read() as db:
        assert db.execute(select(Sitting)).first() is db.execute(select(Submission)).first() is None
        assert db.execute(select(ErasureRequest)).first() is None
    assert school.events() == [(what, None, None) for what in ("erasure_requested", "student_erased")]
    log = told(school.teacher.browser(school.site).get(f"/classes/{school.made.id}/journal"))
    assert "élève effacé" in log
    assert "Ada" not in log


@pytest.mark.parametrize("erase", ["self", "api", "teacher", "admin", "purge"])
def test_the_same_login_has_no_second_clock(school: School, erase: str, monkeypatch: pytest.MonkeyPatch) -> None:
    school.begin()
    with school.site.database.read() as db:
        began = db.execute(select(Sitting.began_at)).scalar_one()
    site = school.site
    if erase == "self":
        school.erase_self()
    elif erase == "api":
        page = school.ada.post("/compte/jetons", data={"label": "x", "password": FORM["password"]}).text
        headers = {"Authorization": "Bearer " + page.split('id="jeton">')[1].split("<")[0]}
        body = {"password": FORM["password"]}
        assert site.client.request("DELETE", "/api/v1/me", headers=headers, json=body).status_code == 202
    elif erase == "teacher":
        assert school.erase().headers["location"] == school.page
    elif erase == "admin":
        assert main(["admin", "erase", "ada", "--yes", "--data", str(site.settings.data_dir)]) == 0
    else:
        personal = PersonalDataService(site.database, Settings(silent_days=1), None)  # type: ignore[arg-type]
        monkeypatch.setattr(personal, "find_expired_students", lambda _now: _accounts(site.database, "ada"))
        assert personal.erase_expired_students(utc_now()) == []
    school.tidy()
    stranger = TestClient(site.app, follow_redirects=False)
    assert stranger.post("/inscription", data=FORM).status_code == 422, "the login is not free"
    second = TestClient(site.app, follow_redirects=False)
    second.post("/inscription", data={**FORM, "login": "ada2"})
    second.post(f"/rejoindre/{school.made.join_code}")
    assert second.post(f"{school.path}/commencer").status_code == 403, "nor the name"
    assert school.begin() == 303
    with site.database.read() as db:
        assert db.execute(select(Sitting.began_at)).scalars().all() == [began]
    logs = 2 if erase == "admin" else 1  # of the class, and of the server for its administrator
    assert [what for what, _, _ in school.events()] == ["erasure_requested"] * logs


def _accounts(database: Database, login: str) -> list[Account]:
    with database.read() as db:
        return list(db.execute(select(Account).where(Account.login == login)).scalars())


def test_a_request_is_carried_out_at_the_latest_after_so_many_days(school: School) -> None:
    school.begin()
    school.erase_self()
    with school.site.database.write() as db:
        db.execute(update(ErasureRequest).values(requested_at=utc_now() - timedelta(days=29)))
    school.tidy()
    assert school.ada_id is not None
    with school.site.database.write() as db:
        db.execute(update(ErasureRequest).values(requested_at=utc_now() - timedelta(days=30)))
    school.tidy()
    assert school.ada_id is None
    with school.site.database.read() as db:
        done = db.execute(select(AuditEvent).where(AuditEvent.what == AuditAction.student_erased)).scalar_one()
    assert (done.about, done.before) == ("Interro", {"attempts": 0}), "the log says which test it did not wait for"


def test_one_s_own_request_is_cancelled_by_oneself_alone(school: School) -> None:
    school.begin()
    school.erase_self()
    teacher = school.teacher.browser(school.site)
    assert "L’élève seul peut l’annuler" in told(teacher.get(school.page))
    assert teacher.post(school.page, data={"action": "annuler"}).status_code == 403
    assert school.ada.post("/compte/supprimer/annuler").status_code == 303
    assert school.ada.post("/compte/supprimer/annuler").status_code == 404
    school.publish()
    school.tidy()
    assert school.ada_id is not None
    assert [what for what, _, _ in school.events()] == ["erasure_requested", "erasure_cancelled"]


def test_a_teacher_s_request_is_cancelled_by_either(school: School) -> None:
    school.begin()
    school.erase()
    assert "Un enseignant de votre classe" in told(school.ada.get("/compte/supprimer"))
    assert school.ada.post("/compte/supprimer/annuler").status_code == 303
    school.erase()
    teacher = school.teacher.browser(school.site)
    assert teacher.post(school.page, data={"action": "annuler"}).status_code == 303
    with school.site.database.read() as db:
        assert db.execute(select(ErasureRequest)).first() is None


def test_a_teacher_sees_what_goes_then_erases_what_was_seen(school: School) -> None:
    school.ada.post("/l20/exercices/poses/soumissions", data={"code": "x = 1"})
    with school.site.database.write() as db:
        db.execute(update(Assignment).values(opens_at=utc_now() + timedelta(days=1)))
    school.ada.post("/l20/exercices/poses/soumissions", data={"code": "x = 1"})
    teacher, address = school.teacher.browser(school.site), school.page
    page = teacher.get(address)
    assert "1 essai" in told(page)
    assert "Le journal de la classe" in told(page) or "le journal de la classe" in told(page)
    seen = re.search(r'name="attendu" value="(\w+)"', page.text)
    assert seen
    assert teacher.post(address, data={"action": "effacer"}).status_code == 200, "nothing without the preview"
    school.ada.post("/l20/exercices/poses/soumissions", data={"code": "x = 2"})
    stale = teacher.post(address, data={"action": "effacer", "attendu": seen[1]})
    assert stale.status_code == 409
    assert "2 essais" in told(stale)
    assert school.ada_id is not None
    assert school.erase().headers["location"] == f"/classes/{school.made.id}/eleves"
    assert school.ada_id is None
    assert teacher.get(address).status_code == 404
    assert school.ada.get("/compte").status_code == 303, "the session has ended"
    assert school.events() == [
        ("erasure_requested", school.teacher.id, None), ("student_erased", school.teacher.id, None),
    ]  # fmt: skip


def test_of_an_account_of_another_class_only_what_it_has_in_this_one_goes(school: School) -> None:
    site = school.site
    roux = person(site, Role.teacher, "M. Roux")
    elsewhere = new_class(site.database, roux.account, "Voisine")
    school.ada.post(f"/rejoindre/{elsewhere.join_code}")
    ada = school.ada_id
    assert ada is not None
    other = assign(site.database, elsewhere, EXERCISE, mode=Mode.test)
    with site.database.write() as db:
        for test in (school.test, other):
            db.add(Sitting(assignment_id=test.id, account_id=ada, began_at=utc_now(), handed_in_at=utc_now()))
            db.add(Exemption(assignment_id=test.id, account_id=ada, excused=True, reason="x"))
            db.add(SavedWork(assignment_id=test.id, account_id=ada, exercise=EXERCISE, source=b"", saved_at=utc_now()))
            test_class = db.get_one(Assignment, test.id).class_id
            column = ManualColumn(class_id=test_class, title="Oral", position=0)
            db.add_all(
                [column, Override(class_id=test_class, account_id=ada, exercise=EXERCISE, reason="", based_on=[])]
            )
            db.flush()
            db.add(ManualMark(column_id=column.id, account_id=ada, points=3.0))
    assert "1 autre classe où vous n’enseignez pas" in told(school.teacher.browser(site).get(school.page))
    assert "Voisine" not in told(school.teacher.browser(site).get(school.page)), "whose names are not told"
    assert school.erase().headers["location"] == school.page, "the test of this class is not published"
    school.publish()
    school.tidy()
    assert school.ada_id == ada
    with site.database.read() as db:
        for table in (Sitting, Exemption, SavedWork, Override, ManualMark, Membership):
            rows = db.execute(select(table).where(table.account_id == ada)).scalars().all()  # type: ignore[attr-defined]
            assert len(rows) == 1, table
        assert db.get(Membership, (elsewhere.id, ada)) is not None
        (event,) = db.execute(select(AuditEvent).where(AuditEvent.what == AuditAction.student_erased)).scalars()
        assert (event.class_id, event.student, event.before) == (school.made.id, ada, {"marks": 2})
    assert school.ada.get("/compte").status_code == 200


def test_every_table_of_a_class_and_an_account_is_erased_with_it() -> None:
    """A table that comes later with both an account's and a class's data is to be named."""
    in_class = {"school_class", "assignment", "manual_column", "rubric", "note", "thread"}
    both = set()
    for table in metadata.tables.values():
        keys = [key for column in table.columns for key in column.foreign_keys if key.ondelete == "CASCADE"]
        targets = {key.column.table.name for key in keys}
        if "account" in targets and targets & in_class:
            both.add(table.name)
    named = {inspect(model).local_table.name for model in repository._conditions_by_table(UUID(int=0), None)}
    assert both - {"erasure_request"} == named


@pytest.mark.parametrize("what", ["teacher", "administrator", "assistant here", "assistant elsewhere", "stranger"])
def test_staff_and_strangers_are_erased_by_nobody_else(school: School, what: str) -> None:
    site, ada = school.site, school.ada_id
    assert ada is not None
    if what in {"teacher", "administrator"}:
        new_account(site.database, Role.administrator)
        with site.database.write() as db:
            db.execute(update(Account).where(Account.id == ada).values(role=what))
    elif what == "stranger":
        with site.database.write() as db:
            db.delete(db.get_one(Membership, (school.made.id, ada)))
    else:
        here = school.made if what == "assistant here" else new_class(site.database, school.teacher.account, "PSI")
        with site.database.write() as db:
            account = db.get_one(Account, ada)
        seat(site.database, here, account, ClassRole.assistant)
    refused = {"stranger": 404}.get(what, 403)
    administrator = person(site, Role.administrator, "Admin")
    for one in (school.teacher, administrator):
        browser = one.browser(site)
        assert browser.get(school.page).status_code == refused
        assert browser.post(school.page, data={"action": "effacer", "attendu": "x"}).status_code == refused
    if what != "stranger":
        assert main(["admin", "erase", "ada", "--yes", "--data", str(site.settings.data_dir)]) == 2
    assert school.ada_id == ada


def test_an_administrator_erases_an_account_of_any_class(school: School) -> None:
    elsewhere = new_class(school.site.database, new_account(school.site.database, Role.teacher), "PSI")
    school.ada.post(f"/rejoindre/{elsewhere.join_code}")
    assert school.erase(person(school.site, Role.administrator, "Admin")).status_code == 303
    assert school.ada_id is None
    assert len(school.events()) == 4, "in the log of each class"


def test_the_command_line_tells_first_erases_and_cancels(school: School, capsys: pytest.CaptureFixture[str]) -> None:
    data = ["--data", str(school.site.settings.data_dir)]
    assert main(["admin", "erase", "ada", *data]) == 0
    assert "rien n’est effacé sans --yes" in capsys.readouterr().out
    school.begin()
    assert main(["admin", "erase", "ada", "--yes", *data]) == 0
    said = capsys.readouterr().out
    assert "Interro" in said
    assert "effacement demandé" in said
    assert main(["admin", "erase", "ada", "--cancel", *data]) == 0
    assert main(["admin", "erase", "ada", "--cancel", *data]) == 2
    school.ada.post(f"{school.path}/rendre")
    school.publish()
    assert main(["admin", "erase", "ada", "--yes", "--json", *data]) == 0
    assert '"erased": true' in capsys.readouterr().out
    assert school.ada_id is None


def test_what_was_interrupted_is_finished_and_not_cancelled(school: School) -> None:
    ada = school.ada_id
    assert ada is not None
    with school.site.database.write() as db:
        erasures.request_erasure(db, ada, None, ada, utc_now())
        assert erasures.begin_erasure_if_allowed(db, ada, None, school.site.settings, utc_now())
    assert school.ada.get("/compte").status_code == 303, "nobody enters any more"
    assert school.begin() == 401
    assert school.teacher.browser(school.site).post(school.page, data={"action": "annuler"}).status_code == 409
    school.tidy()
    assert school.ada_id is None


def test_on_both_databases_erasing_and_beginning_at_once_leave_one_or_the_other(
    database: Database, both: Settings
) -> None:
    """Either the sitting is there, and the account waits; or the account goes, and the test was not begun."""
    made = new_class(database, new_account(database, Role.teacher, "Mme Martin"))
    test = assign(database, made, EXERCISE, mode=Mode.test)
    personal = PersonalDataService(database, both, None)  # type: ignore[arg-type]
    for _ in range(8):
        ada = seat(database, made, new_account(database))
        together, begun, erased = threading.Barrier(2), [], []

        def begin(account: Account = ada, start: threading.Barrier = together, done: list[bool] = begun) -> None:
            start.wait()
            try:
                with database.write() as db:
                    membership = db.get(Membership, (made.id, account.id))
                    if membership is None:
                        return
                    row = db.get_one(Assignment, test.id)
                    eligibility.require_may_begin(db, row, account, membership)
                    sittings.begin_sitting(db, row, account.id, (), utc_now())
                done.append(True)
            except (Forbidden, WrongMoment):
                return

        def erase(account: Account = ada, start: threading.Barrier = together, done: list[bool] = erased) -> None:
            start.wait()
            done.append(personal.erase_on_request(account.id))

        threads = [threading.Thread(target=act) for act in (begin, erase)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        with database.read() as db:
            exists, sits = db.get(Account, ada.id) is not None, db.get(Sitting, (test.id, ada.id)) is not None
        assert len(erased) == 1
        assert exists == sits == bool(begun) == (not erased[0])
