"""What is kept of a person is taken away whole, and erased whole."""

from __future__ import annotations

import io
import json
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import timedelta
from random import Random
from typing import Any
from uuid import UUID

import pytest
from sqlalchemy import func, select, text, update

from server.app import ApplicationServices
from server.audit import service as audit
from server.audit.models import AuditAction, AuditEvent
from server.base.app_services import add_services, get_service
from server.base.settings import Settings
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.cli import main
from server.comments import notes
from server.comments import service as comments
from server.comments.schemas import ThreadTarget
from server.course import Course
from server.database import Database, utc_now
from server.gradebook.models import Grading, SolutionOpening, Standing
from server.gradebook.service import find_attempt
from server.identity import tokens
from server.identity.models import Account, ApiToken, BrowserSession, Role
from server.marks import service as marks
from server.marks.models import Override
from server.marks.repository import load_prevailing_overrides
from server.personal import service
from server.personal.guest_adoption import adopt_guest_data
from server.personal.service import PersonalDataService
from server.personal.zip_stream import CHUNK_BYTES, stream_zip
from server.queue.models import Job
from server.submissions.models import Submission, Variant
from server.submissions.service import SubmissionService
from tests.support.classes import new_class, seat
from tests.support.client import TestClient
from tests.support.service import EXERCISE, QUIET, Site, new_account, worker_of

FORM = {"name": "Ada L.", "login": "ada", "password": "notes sur la machine"}
POSES, ANSWERS = "/l20/exercices/poses", "/l20/exercices/calcul_odometrie"
CODE = "# é\r\nx = 1\n"


@pytest.fixture
def ada(site: Site) -> Site:
    """Somebody who has signed up, sent a file that was graded and answers that wait, and made a token."""
    site.client.post("/inscription", data=FORM)
    site.client.post(f"{POSES}/soumissions", data={"code": CODE})
    assert site.worker.run_one()
    site.client.get(ANSWERS)
    site.client.post(f"{ANSWERS}/soumissions", data={"ds": "0,1"})
    site.client.post("/compte/jetons", data={"label": "portable", "password": FORM["password"]})
    return site


def archive(answer: Any) -> zipfile.ZipFile:
    assert answer.status_code == 200
    assert answer.headers["content-type"] == "application/zip"
    assert answer.headers["content-disposition"].startswith('attachment; filename="balise-mes-donnees-')
    assert answer.headers["content-encoding"] == "identity"
    files = zipfile.ZipFile(io.BytesIO(answer.content))
    assert files.testzip() is None
    return files


def read(files: zipfile.ZipFile, name: str) -> Any:
    return json.loads(files.read(name))


def counts(database: Database) -> dict[type, int]:
    with database.read() as db:
        return {
            table: db.execute(select(func.count()).select_from(table)).scalar_one()
            for table in (Account, BrowserSession, ApiToken, Submission, Grading, Standing, Variant)
        }


def test_all_of_it_is_in_the_archive_and_nobody_else_s(ada: Site) -> None:
    stranger = TestClient(ada.app, follow_redirects=False)
    stranger.post("/inscription", data={**FORM, "name": "Bob", "login": "bob"})
    stranger.post(f"{POSES}/soumissions", data={"code": "secret_de_bob"})
    files = archive(ada.client.get("/compte/donnees"))
    account = read(files, "compte.json")
    assert (account["name"], account["login"], account["role"]) == ("Ada L.", "ada", "student")
    assert [token["label"] for token in account["api_tokens"]] == ["portable"]
    assert len(account["sessions"]) == 1
    exercises = read(files, "exercices.json")
    assert [(one["exercise"], one["best_score"]) for one in exercises["standings"]] == [(EXERCISE, 1.0)]
    assert [one["exercise"] for one in exercises["deals"]] == ["l20/calcul_odometrie"]
    sent = {name.rpartition("/")[2]: name for name in files.namelist() if name.startswith(f"essais/{EXERCISE}/")}
    assert files.read(sent["reponse.py"]).decode() == CODE.replace("\r\n", "\n")
    (grading,) = read(files, sent["corrections.json"])["gradings"]
    assert (grading["counts"], grading["verdict"]["points"]) == (True, 20)
    (waiting,) = [name for name in files.namelist() if "calcul_odometrie" in name and name.endswith("corrections.json")]
    assert read(files, waiting)["gradings"] == []
    assert waiting.replace("corrections", "reponse") in files.namelist()
    everything = b"".join(files.read(name) for name in files.namelist())
    for hidden in (b"argon2", b"secret_de_bob", b"digest", b"bob"):
        assert hidden not in everything


def test_it_is_given_to_its_owner_alone_and_not_too_often(ada: Site, course: Course) -> None:
    nobody = TestClient(ada.app, follow_redirects=False)
    assert nobody.get("/compte/donnees").status_code == 401
    assert nobody.get("/api/v1/me/export").status_code == 401
    slow = ada.settings.model_copy(update={"export_burst": 1, "export_refill_seconds": 1000.0})
    add_services(ada.app, PersonalDataService(ada.database, slow, course))
    assert ada.client.get("/compte/donnees").status_code == 200
    assert ada.client.get("/compte/donnees").status_code == 429


def test_many_attempts_are_read_a_few_at_a_time(ada: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("server.personal.export.BATCH_SIZE", 2)
    for number in range(4):
        ada.client.post(f"{POSES}/soumissions", data={"code": f"x = {number}"})
    names = archive(ada.client.get("/compte/donnees")).namelist()
    assert len([name for name in names if name.endswith("/reponse.py")]) == 5
    assert len(names) == len(set(names))


def test_an_archive_is_sent_while_it_is_made() -> None:
    made: list[int] = []

    def files() -> Iterator[tuple[str, bytes]]:
        for number in range(20):
            made.append(number)
            yield f"{number}", Random(number).randbytes(CHUNK_BYTES)

    pieces = stream_zip(files(), utc_now())
    first = next(pieces)
    assert len(made) < 10
    rest = list(pieces)
    assert max(map(len, [first, *rest])) < 3 * CHUNK_BYTES
    with zipfile.ZipFile(io.BytesIO(b"".join([first, *rest]))) as archive:
        assert archive.testzip() is None
        assert len(archive.namelist()) == 20


def test_erasing_asks_for_the_password_and_leaves_nothing(ada: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(service, "ERASE_BATCH", 1)
    before = counts(ada.database)
    assert before == {Account: 1, BrowserSession: 1, ApiToken: 1, Submission: 2, Grading: 1, Standing: 1, Variant: 1}
    assert ada.client.get("/compte/supprimer").status_code == 200
    refused = ada.client.post("/compte/supprimer", data={"password": "au hasard"})
    assert (refused.status_code, 'id="password-probleme"' in refused.text) == (422, True)
    assert counts(ada.database) == before
    done = ada.client.post("/compte/supprimer", data={"password": FORM["password"]})
    assert (done.status_code, done.headers["location"]) == (303, "/compte/efface")
    assert ada.client.get("/compte/efface").status_code == 200
    assert set(counts(ada.database).values()) == {0}
    assert ada.client.post("/connexion", data=FORM).status_code == 422
    while ada.worker.run_one():  # what waited is of nobody any more
        pass
    with ada.database.read() as db:
        assert db.execute(select(Job)).first() is None


def test_a_guest_is_erased_without_a_password(site: Site) -> None:
    site.client.post(f"{POSES}/soumissions", data={"code": CODE})
    assert 'name="password"' not in site.client.get("/compte/supprimer").text
    assert site.client.post("/compte/supprimer").status_code == 303
    assert set(counts(site.database).values()) == {0}


def test_a_token_takes_away_and_erases_with_the_password_alone(ada: Site) -> None:
    page = ada.client.post("/compte/jetons", data={"label": "autre", "password": FORM["password"]}).text
    headers = {"Authorization": "Bearer " + page.split('id="jeton">')[1].split("<")[0]}
    archive(ada.client.get("/api/v1/me/export", headers=headers))

    def erase(**body: str) -> int:
        return ada.client.request(
            "DELETE", "/api/v1/me", headers=headers, **({"json": body} if body else {})
        ).status_code

    assert [erase(password="au hasard"), erase(mot="x")] == [422, 422]
    assert counts(ada.database)[Account] == 1
    assert erase() == 403, "a token alone erases nothing"
    assert counts(ada.database)[Account] == 1
    assert erase(password=FORM["password"]) == 204
    assert erase(password=FORM["password"]) == 401
    assert set(counts(ada.database).values()) == {0}


def test_what_a_teacher_opened_stays_open_without_a_name(database: Database, both: Any, course: Any) -> None:
    teacher, ada = new_account(database, Role.teacher), new_account(database)
    store = SubmissionService(both, QUIET)
    with database.write() as db:
        db.add(SolutionOpening(exercise=EXERCISE, opened_by=teacher.id))
        for account in (teacher, ada):
            store.submit(db, account, EXERCISE, "pass", address="192.0.2.1")
    while worker_of(database, both).run_one():
        pass
    PersonalDataService(database, both, course).erase(teacher.id)
    with database.read() as db:
        opening = db.execute(select(SolutionOpening)).scalar_one()
        assert (opening.exercise, opening.opened_by) == (EXERCISE, None)
        assert db.execute(select(Submission.account_id)).scalars().all() == [ada.id]
        assert db.execute(select(func.count()).select_from(Grading)).scalar_one() == 1


def test_erasing_does_not_read_every_submission(sqlite: Database) -> None:
    """Without an index, each grading that goes would have SQLite look for it in all submissions, holding its lock."""
    with sqlite.read() as db:
        plan = db.execute(text("EXPLAIN QUERY PLAN SELECT 1 FROM submission WHERE grading_id = 'x'")).all()
    assert "USING COVERING INDEX ix_submission_grading_id" in str(plan)


def test_guests_that_nothing_leads_to_are_forgotten(site: Site) -> None:
    site.client.post(f"{POSES}/soumissions", data={"code": CODE})
    kept = new_account(site.database)  # a student without a session
    personal = PersonalDataService(site.database, site.settings, None)  # type: ignore[arg-type]
    later = utc_now() + timedelta(days=2)
    assert personal.erase_unreachable_and_idle_guests(later) == 0, "its browser may come back"
    site.client.post("/deconnexion")
    assert personal.erase_unreachable_and_idle_guests(utc_now()) == 0, "not the same day"
    assert personal.erase_unreachable_and_idle_guests(later) == 1
    with site.database.read() as db:
        assert db.execute(select(Account.id)).scalars().all() == [kept.id]
        assert db.execute(select(Submission)).first() is None


def test_what_has_ended_is_removed_however_long_the_service_runs(site: Site, monkeypatch: pytest.MonkeyPatch) -> None:
    site.client.post(f"{POSES}/soumissions", data={"code": CODE})
    with site.database.write() as db:
        db.execute(update(BrowserSession).values(expires_at=utc_now() - timedelta(seconds=1)))
        db.execute(update(Account).values(created_at=utc_now() - timedelta(days=400)))
    ApplicationServices(site.settings, None, ()).delete_expired_data()  # type: ignore[arg-type]
    assert set(counts(site.database).values()) == {0}


def test_the_page_tells_how_long_each_thing_is_kept(site: Site) -> None:
    site.tighten(session_days=123, api_token_days=45, password_link_hours=6)
    page = site.client.get("/donnees-personnelles").text
    for told in ("123 jours", "45 jours", "6 heures", "8 jours", "balise_session", "CNIL", "n’a pas fixé de durée"):
        assert told in page
    site.tighten(left_days=91, silent_days=730)
    page = site.client.get("/donnees-personnelles").text
    assert "91 jours après la fin de sa dernière classe" in " ".join(page.split())
    assert "730 jours" in page
    assert 'href="/donnees-personnelles"' in site.client.get("/").text


@dataclass(frozen=True)
class Establishment:
    """A class, with students of whom nothing was heard for 200 days but that they left it 100 days ago."""

    database: Database
    made: SchoolClass

    def student(self, heard: int = 200, **membership: Any) -> UUID:
        account = new_account(self.database)
        left = utc_now() - timedelta(days=100)
        values = {"created_by_list": True, "status": Status.left, "left_at": left, **membership}
        seat(self.database, self.made, account, **values)
        with self.database.write() as db:
            row = db.get_one(Account, account.id)
            row.created_at = utc_now() - timedelta(days=heard)
        return account.id

    def outdated(self, **settings: int) -> set[UUID]:
        kept = Settings(**settings)  # type: ignore[arg-type]
        personal = PersonalDataService(self.database, kept, None)  # type: ignore[arg-type]
        return {account.id for account in personal.find_expired_students(utc_now())}


@pytest.fixture
def school(database: Database) -> Establishment:
    return Establishment(database, new_class(database, new_account(database, Role.teacher, "Mme Martin")))


def test_who_left_long_ago_is_kept_as_long_as_the_establishment_says(school: Establishment) -> None:
    gone = school.student()
    active = school.student(status=Status.active, left_at=None)
    lately = school.student(left_at=utc_now() - timedelta(days=10))
    own_account = school.student(created_by_list=False)
    heard_of = school.student(heard=5)
    helps = school.student()
    other = new_class(school.database, new_account(school.database, Role.teacher))
    with school.database.write() as db:
        db.add(Membership(class_id=other.id, account_id=helps, role=ClassRole.assistant))
    assert school.outdated() == set(), "by default nobody is erased"
    assert school.outdated(left_days=90) == {gone}
    assert school.outdated(left_days=120) == set()
    assert school.outdated(silent_days=150) == {gone, active, lately, own_account}
    assert heard_of not in school.outdated(silent_days=6)
    with school.database.write() as db:
        db.get_one(SchoolClass, school.made.id).archived_at = utc_now() - timedelta(days=95)
    assert school.outdated(left_days=90) == {gone, active}, "a class that is archived has ended"


def test_what_is_heard_of_somebody_keeps_them(school: Establishment) -> None:
    seen = school.student(last_seen_at=utc_now())
    sends, logs_in, has_token = (school.student() for _ in range(3))
    with school.database.write() as db:
        db.add(Submission(account_id=sends, exercise=EXERCISE, source=b"", digest="", seed=0))
        db.add(BrowserSession(token_digest="x", account_id=logs_in, expires_at=utc_now()))
        tokens.create_token(db, db.get_one(Account, has_token), "portable", Settings())
    assert school.outdated(left_days=90, silent_days=90).isdisjoint({seen, sends, logs_in, has_token})


def test_who_is_kept_no_longer_is_erased_by_the_service(school: Establishment) -> None:
    gone, kept = school.student(), school.student(status=Status.active, left_at=None)
    PersonalDataService(school.database, Settings(left_days=90), None).erase_expired_students(utc_now())  # type: ignore[arg-type]
    with school.database.read() as db:
        assert db.get(Account, gone) is None
        assert db.get(Account, kept) is not None


def test_the_command_line_tells_first_and_erases_when_told(
    site: Site, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made = new_class(site.database, new_account(site.database, Role.teacher))
    gone = Establishment(site.database, made).student()
    purge = ["admin", "purge", "--data", str(site.settings.data_dir)]
    assert main(purge) == 2
    assert "BALISE_LEFT_DAYS" in capsys.readouterr().err
    monkeypatch.setenv("BALISE_LEFT_DAYS", "90")
    assert main(purge) == 0
    assert "1 compte à effacer" in capsys.readouterr().out
    assert main([*purge, "--yes"]) == 0
    assert "1 compte effacé" in capsys.readouterr().out
    with site.database.read() as db:
        assert db.get(Account, gone) is None


def test_what_is_said_is_taken_away_without_the_names_of_others(ada: Site) -> None:
    teacher = new_account(ada.database, Role.teacher, "Mme Martin")
    made = new_class(ada.database, teacher)
    with ada.database.write() as db:
        account = db.execute(select(Account).where(Account.login == "ada")).scalar_one()
        sent = db.execute(select(Submission).where(Submission.exercise == EXERCISE)).scalar_one()
        db.add(Membership(class_id=made.id, account_id=account.id))
        db.flush()
        asked = comments.begin_thread(
            db, account, find_attempt(db, account, sent.id), ThreadTarget(check="a"), "Pourquoi ?", ada.settings
        )
        comments.reply_to_thread(db, teacher, asked, "Relisez.", ada.settings)
        notes.save_phrase(db, teacher, "Relisez l’énoncé.", EXERCISE, None)
        notes.send_note_to_students(db, teacher, made, EXERCISE, None, "À tous", "", ada.settings)
    files = archive(ada.client.get("/compte/donnees"))
    told = read(files, "messages.json")
    (thread,) = told["threads"]
    assert (thread["submission"], thread["check"], thread["state"]) == (str(sent.id), "a", "answered")
    assert [(one["by"], one["text"]) for one in thread["messages"]] == [("you", "Pourquoi ?"), ("staff", "Relisez.")]
    assert [one["text"] for one in told["words_to_you_and_others"]] == ["À tous"]
    assert b"Martin" not in files.read("messages.json")
    with ada.database.read() as db:
        own = comments.load_account_comments(db, teacher.id)
    assert [one.text for one, _ in own.staff_messages] == ["Relisez."]
    assert [[one.text for one in several] for several in (own.phrases, own.sent_notes)] == [
        ["Relisez l’énoncé."],
        ["À tous"],
    ]


def test_classes_are_taken_away_and_left_with_the_account(ada: Site) -> None:
    teacher = new_account(ada.database, Role.teacher, "Mme Martin")
    made = new_class(ada.database, teacher)
    with ada.database.read() as db:
        account = db.execute(select(Account).where(Account.login == "ada")).scalar_one()
    seat(ada.database, made, account, family_name="Lovelace", groups=["TP1"])
    (one,) = read(archive(ada.client.get("/compte/donnees")), "classes.json")
    assert (one["class"], one["role"], one["status"]) == ("MPSI 2", "student", "active")
    assert (one["family_name"], one["groups"]) == ("Lovelace", ["TP1"])
    get_service(ada.app, PersonalDataService).erase(account.id)
    get_service(ada.app, PersonalDataService).erase(teacher.id)
    with ada.database.read() as db:
        assert db.execute(select(Membership)).first() is None
        assert db.execute(select(SchoolClass.created_by)).scalar_one() is None


def test_marks_and_the_log_are_taken_away_and_the_log_forgets_who(ada: Site, course: Course) -> None:
    teacher = new_account(ada.database, Role.teacher, "Mme Martin")
    made = new_class(ada.database, teacher)
    with ada.database.read() as db:
        account = db.execute(select(Account).where(Account.login == "ada")).scalar_one()
    seat(ada.database, made, account)
    with ada.database.write() as db:
        marks.set_override(
            db, course, made, teacher, account.id, EXERCISE, points=12.0, excused=False, reason="malade ce jour-là"
        )
        audit.record_event(
            db, made.id, teacher.id, AuditAction.exemption_made, student=account.id, about="DM 1", reason="dyslexie"
        )
    kept = read(archive(ada.client.get("/compte/donnees")), "notes.json")
    (override,) = kept["overrides"]
    assert (override["points"], override["reason"], override["withdrawn_at"]) == (12.0, "malade ce jour-là", None)
    changed = {one["what"]: one["reason"] for one in kept["changes_about_you"]}
    assert changed == {"mark_overridden": "malade ce jour-là", "exemption_made": ""}
    assert kept["changes_you_made"] == kept["overrides_you_set"] == []
    get_service(ada.app, PersonalDataService).erase(account.id)
    get_service(ada.app, PersonalDataService).erase(teacher.id)
    with ada.database.read() as db:
        assert db.execute(select(Override)).first() is None
        events = db.execute(select(AuditEvent)).scalars().all()
        assert [(one.by, one.student, one.reason) for one in events] == [(None, None, "")] * 2


def test_a_guest_s_marks_follow_into_the_account(sqlite: Database, course: Course) -> None:
    teacher = new_account(sqlite, Role.teacher, "Mme Martin")
    made = new_class(sqlite, teacher)
    guest, account = (seat(sqlite, made, new_account(sqlite)) for _ in range(2))
    with sqlite.write() as db:
        for student, exercise, points in (
            (guest, EXERCISE, 3.0), (guest, "l20/calcul_odometrie", 4.0), (account, EXERCISE, 5.0),
        ):  # fmt: skip
            marks.set_override(
                db, course, made, teacher, student.id, exercise, points=points, excused=False, reason="x"
            )
        adopt_guest_data(db, guest.id, account.id)
    with sqlite.read() as db:
        found = load_prevailing_overrides(db, made.id)
        assert {key: one.points for key, one in found.items()} == {
            (account.id, EXERCISE): 5.0, (account.id, "l20/calcul_odometrie"): 4.0,
        }  # fmt: skip
        assert {one.student for one in db.execute(select(AuditEvent)).scalars()} == {account.id}
