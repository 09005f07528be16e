"""`balise admin`: accounts, what opens them, and what is put right by hand."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from datetime import timedelta
from typing import Any
from uuid import UUID, uuid4

import pytest
from sqlalchemy import delete, select, update

from graders.core.contract.outcomes import Outcome
from server.audit.models import AuditAction
from server.cli import main
from server.cli.admin import ACTIONS
from server.database import Database, utc_now
from server.gradebook.models import Grading
from server.identity import administration, links, service, tokens
from server.identity.models import Account, BrowserSession, Role
from server.polls.models import PollAnswer
from server.queue.models import Job
from server.submissions.models import Submission
from tests.support.classes import person
from tests.support.service import Site, new_account

PASSWORD = "notes sur la machine"
Admin = Callable[..., dict[str, Any]]


@pytest.fixture
def admin(site: Site, capsys: pytest.CaptureFixture[str]) -> Admin:
    """Runs an action with `--json`; what it answers, or its refusal."""

    def run(*arguments: str) -> dict[str, Any]:
        status = main(["admin", *arguments, "--json", "--data", str(site.settings.data_dir)])
        said = capsys.readouterr()
        assert status == (2 if said.err else 0)
        answer: dict[str, Any] = {"refused": said.err} if said.err else json.loads(said.out)
        return answer

    return run


def log_in(site: Site, login: str = "ada") -> Any:
    site.client.cookies.clear()
    return site.client.post("/connexion", data={"login": login, "password": PASSWORD})


def account(site: Site, login: str) -> Account:
    with site.database.read() as db:
        return links.find_account_by_login_or_id(db, login)


def test_a_first_teacher_is_made_or_invited_from_the_command_line(site: Site, admin: Admin) -> None:
    made = admin(
        "create", "Ada@Example.org", "--name", "Ada  L.", "--role", "teacher", "--server", "https://b.example/"
    )
    assert (made["login"], made["name"], made["role"]) == ("ada@example.org", "Ada L.", "teacher")
    path = made["link"].removeprefix("https://b.example")
    assert site.client.post(path, data={"new_password": PASSWORD}).status_code == 303
    assert "Créer une classe" in site.client.get("/classes").text
    assert "n’est pas disponible" in admin("create", "ada@example.org", "--name", "Une autre")["refused"]
    assert "identifiant compte" in admin("create", "a b", "--name", "Ada")["refused"]

    invited = admin("invite")
    form = {"name": "Bob", "login": "bob", "password": PASSWORD}
    for status in (303, 404):
        site.client.cookies.clear()
        assert site.client.post(invited["link"], data=form).status_code == status
    assert account(site, "bob").role == Role.teacher
    assert [one["login"] for one in admin("accounts", "--role", "teacher")["accounts"]] == ["ada@example.org", "bob"]
    assert admin("accounts", "--search", "BO", "--most", "1")["accounts"][0]["login"] == "bob"


def test_an_invitation_ends(site: Site) -> None:
    with site.database.write() as db:
        late = links.create_invitation(db, Role.teacher, timedelta(seconds=-1))
    assert site.client.get(f"/bienvenue/{late}").status_code == 404
    form = {"name": "Bob", "login": "bob", "password": PASSWORD}
    assert site.client.post(f"/bienvenue/{late}", data=form).status_code == 404


def test_nobody_enters_by_a_disabled_account_until_it_is_enabled(site: Site, admin: Admin) -> None:
    link = admin("create", "ada", "--name", "Ada")["link"]
    site.client.post(link, data={"new_password": PASSWORD})
    with site.database.write() as db:
        _, secret = tokens.create_token(db, links.find_account_by_login_or_id(db, "ada"), "essai", site.settings)
    api = {"Authorization": f"Bearer {secret}"}
    waiting = admin("reset-link", "ada")["link"]
    assert admin("disable", "ada")["disabled_at"]
    assert "Se connecter" in site.client.get("/").text
    assert site.client.get(f"/api/v1/submissions/{uuid4()}", headers=api).status_code == 401
    assert site.client.post(waiting, data={"new_password": PASSWORD}).status_code == 404
    assert "suspendu" in log_in(site).text
    assert "suspendu" not in site.client.post("/connexion", data={"login": "ada", "password": "autre chose"}).text
    assert "suspendu" in admin("reset-link", "ada")["refused"]
    assert admin("enable", "ada")["disabled_at"] is None
    assert log_in(site).status_code == 303


def test_a_session_opened_beside_a_disabling_does_not_serve(site: Site) -> None:
    ada = new_account(site.database)
    with site.database.write() as db:
        opened = site.accounts.open_session(db, ada)
        db.execute(update(Account).values(disabled_at=utc_now()))
    with site.database.read() as db:
        assert service.find_account_by_session_token(db, opened.token) is None


def test_the_last_administrator_who_can_enter_stays(admin: Admin) -> None:
    for login in ("ada", "bob"):
        admin("create", login, "--name", login, "--role", "administrator")
    assert "refused" not in admin("disable", "ada")
    assert "au moins un administrateur" in admin("disable", "bob")["refused"]
    assert "au moins un administrateur" in admin("role", "bob", "teacher")["refused"]
    assert admin("role", "ada", "teacher")["role"] == "teacher"


def test_sessions_and_tokens_are_listed_without_their_secrets_and_revoked(site: Site, admin: Admin) -> None:
    site.client.post(admin("create", "ada", "--name", "Ada")["link"], data={"new_password": PASSWORD})
    cookie = site.client.cookies["balise_session"]
    with site.database.write() as db:
        token, secret = tokens.create_token(db, links.find_account_by_login_or_id(db, "ada"), "portable", site.settings)
        digests = [token.token_digest, db.execute(select(BrowserSession.token_digest)).scalar_one()]
    listed = [admin("sessions", "ada"), admin("tokens", "ada")]
    assert listed[1]["tokens"][0]["label"] == "portable"
    assert not any(hidden in json.dumps(listed) for hidden in (cookie, secret, *digests))
    (session,) = listed[0]["sessions"]
    assert "n’a ni session ni jeton" in admin("revoke", "ada", "zut")["refused"]
    assert "refused" in admin("revoke", "ada")
    assert admin("revoke", "ada", session["id"], str(token.id)) == {"revoked": 2}
    assert (admin("sessions", "ada")["sessions"], admin("tokens", "ada")["tokens"]) == ([], [])
    log_in(site)
    assert admin("revoke", "ada", "--all") == {"revoked": 1}
    assert "Se connecter" in site.client.get("/").text


def test_guests_without_work_go_and_the_others_stay(site: Site, admin: Admin) -> None:
    long_ago = utc_now() - timedelta(days=9)
    idle, busy, asked, recent = (new_account(site.database, Role.guest) for _ in range(4))
    student = new_account(site.database)
    with site.database.write() as db:
        db.execute(update(Account).where(Account.id != recent.id).values(created_at=long_ago))
        db.add(PollAnswer(account_id=asked.id, poll="l20/une-question", answer="a", last="a", tries=1))
        db.add(Submission(account_id=busy.id, exercise="l20/poses", source=b"pass", digest="d", seed=1))
    assert admin("purge-guests") == {"guests": 1, "erased": False}
    assert admin("purge-guests", "--yes") == {"guests": 1, "erased": True}
    with site.database.read() as db:
        left = set(db.execute(select(Account.id)).scalars())
    assert left == {busy.id, asked.id, recent.id, student.id}
    assert idle.id not in left


def test_what_nothing_grades_is_queued_again(site: Site, admin: Admin) -> None:
    headers = site.token()
    lost, failed, graded = (site.submit(headers, code)["id"] for code in ("pass", "outcome: internal_error", "x = 1"))
    while site.worker.run_one():
        pass
    with site.database.write() as db:
        db.execute(update(Submission).where(Submission.id == UUID(lost)).values(grading_id=None))
        db.execute(delete(Job))
    assert admin("requeue")["requeued"] == [lost]
    assert admin("requeue")["requeued"] == [], "it waits already"
    assert admin("requeue", "--failed")["requeued"] == [failed]
    assert "a son verdict" in admin("requeue", graded)["refused"]
    assert "n’existe pas" in admin("requeue", "zut")["refused"]
    while site.worker.run_one():
        pass
    assert outcomes(site.database, lost) == [Outcome.OK, Outcome.OK]
    assert outcomes(site.database, failed) == [Outcome.INTERNAL_ERROR] * 2


def outcomes(database: Database, submission: str) -> list[str]:
    with database.read() as db:
        query = select(Grading.outcome).where(Grading.submission_id == UUID(submission))
        return list(db.execute(query.order_by(Grading.finished_at)).scalars())


def test_every_action_is_told_to_people_too(
    site: Site, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BALISE_SMTP_HOST", "smtp.lycee.example")
    new_account(site.database, Role.guest)
    with site.database.write() as db:
        administration.create_account(db, "ada", "Ada", Role.teacher)
    actions = [
        ("create", "bob", "--name", "Bob"), ("invite",), ("reset-link", "ada"), ("role", "ada", "teacher"),
        ("disable", "ada"), ("enable", "ada"), ("accounts",), ("sessions", "ada"), ("tokens", "ada"),
        ("revoke", "ada", "--all"), ("standings",), ("purge-guests", "--days", "0"), ("requeue",),
        ("log",), ("mail",),
    ]  # fmt: skip
    assert {name for name, *_ in actions} == ACTIONS.keys() - {"purge", "erase"}, (
        "which have their tests with what it erases"
    )
    for action in actions:
        assert main(["admin", *action, "--data", str(site.settings.data_dir)]) == 0
        said = capsys.readouterr().out
        assert re.search(r"\w", said)
        assert "{" not in said


#: A run of each action, after the ones before it; None for those that change nothing.
RECORDED: dict[str, tuple[tuple[str, ...], AuditAction | None]] = {
    "create": (("bob", "--name", "Bob"), AuditAction.account_created),
    "accounts": ((), None),
    "disable": (("bob",), AuditAction.account_disabled),
    "enable": (("bob",), AuditAction.account_enabled),
    "invite": ((), AuditAction.invitation_made),
    "reset-link": (("bob",), AuditAction.password_link_made),
    "role": (("bob", "teacher"), AuditAction.role_changed),
    "revoke": (("bob", "--all"), AuditAction.access_revoked),
    "sessions": (("bob",), None),
    "tokens": (("bob",), None),
    "standings": ((), AuditAction.standings_rebuilt),
    "requeue": ((), AuditAction.submissions_requeued),
    "purge": (("--yes",), AuditAction.accounts_purged),
    "purge-guests": (("--yes",), AuditAction.guests_purged),
    "erase": (("ada", "--yes"), AuditAction.erasure_requested),
    "log": ((), None),
    "mail": ((), None),
}


def test_the_log_has_every_action_that_changes_something(
    site: Site, admin: Admin, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("BALISE_SILENT_DAYS", "400")
    monkeypatch.setenv("BALISE_SMTP_HOST", "smtp.lycee.example")
    admin("create", "ada", "--name", "Ada")
    assert set(RECORDED) == set(ACTIONS)
    for action, (arguments, _) in RECORDED.items():
        assert "refused" not in admin(action, *arguments), action
    logged = admin("log")
    expected = [AuditAction.account_created]
    expected += [recorded for _, recorded in RECORDED.values() if recorded is not None]
    assert [AuditAction(event["action"]) for event in logged["actions"]] == expected[::-1]
    assert logged["total"] == len(expected)
    role = next(event for event in logged["actions"] if event["action"] == "role_changed")
    assert (role["before"], role["after"]) == ({"role": "student"}, {"role": "teacher"})
    assert role["about"].startswith("ligne de commande, utilisateur ")


def test_what_only_tells_leaves_no_line_in_the_log(site: Site, admin: Admin) -> None:
    admin("create", "ada", "--name", "Ada")
    admin("erase", "ada")
    admin("purge-guests")
    assert admin("disable", "nobody")["refused"]
    assert admin("log")["total"] == 1


def test_administrators_read_the_log_on_a_page(site: Site, admin: Admin) -> None:
    admin("create", "bob", "--name", "Bob le Bref", "--role", "teacher")
    administrator = person(site, Role.administrator, "Ada")
    page = administrator.browser(site).get("/administration/journal").text
    assert "compte créé" in page
    assert "Bob le Bref" in page
    assert "enseignant" in page
    assert person(site, Role.teacher, "Prof").browser(site).get("/administration/journal").status_code == 403


def test_the_log_has_the_account_that_an_invitation_made(site: Site, admin: Admin) -> None:
    with site.database.write() as db:
        token = links.create_invitation(db, Role.teacher, timedelta(days=1))
    form = {"name": "Marie", "login": "marie", "password": "une phrase bien longue"}
    assert site.client.post(f"/bienvenue/{token}", data=form).status_code == 303
    (event,) = admin("log")["actions"]
    assert (event["action"], event["after"]) == (AuditAction.account_created, {"role": "teacher"})
    assert event["account"] is not None
    assert event["about"] == "lien à usage unique"
