"""Identities in other systems: a credential beside the password, which opens nobody else's account."""

from __future__ import annotations

import io
import json
import zipfile
from concurrent.futures import ThreadPoolExecutor
from datetime import timedelta
from uuid import uuid4

import pytest
from sqlalchemy import select, update

from server.base.errors import Conflict, Forbidden, NotFound
from server.base.http import FRAMED_COOKIE, SESSION_COOKIE
from server.classes.models import Membership
from server.database import Database, utc_now
from server.identity import joining, links
from server.identity.identities import FRESH_SESSION, ExternalPerson
from server.identity.models import Account, BrowserSession, FederatedIdentity, Role
from server.identity.opened_sessions import OpenedSession
from server.identity.service import AccountService
from server.submissions.models import Submission
from tests.support.classes import assign, new_class, person, seat
from tests.support.client import TestClient
from tests.support.service import EXERCISE, Site

MOODLE, OTHER = "https://moodle.example", "https://canvas.example"
FORM = {"name": "Ada Lovelace", "login": "ada", "password": "notes sur la machine"}


def come(site: Site, subject: str = "7", issuer: str = MOODLE, **fields: object) -> OpenedSession:
    visitor = fields.pop("visitor", None)
    with site.database.write() as db:
        return joining.open_identity_session(site.accounts, db, ExternalPerson(issuer, subject, **fields), visitor)  # type: ignore[arg-type]


def browser(site: Site, opened: OpenedSession) -> TestClient:
    return TestClient(site.app, cookies={SESSION_COOKIE: opened.token}, follow_redirects=False)


def age(site: Site, by: timedelta = FRESH_SESSION * 2) -> None:
    with site.database.write() as db:
        db.execute(update(BrowserSession).values(created_at=utc_now() - by))


def test_one_person_has_one_account_however_many_come_at_once(database: Database, both: object) -> None:
    accounts = AccountService(database, both, adopt_guest_data=lambda *_: None)  # type: ignore[arg-type]

    def come_once(_: int) -> object:
        with database.write() as db:
            return joining.open_identity_session(accounts, db, ExternalPerson(MOODLE, "7"), None).account.id

    with ThreadPoolExecutor(8) as pool:
        assert len(set(pool.map(come_once, range(16)))) == 1
    with database.read() as db:
        (account,) = db.execute(select(Account)).scalars()
        assert (account.login, account.is_guest, account.has_pseudonym) == (None, False, True)
        assert db.execute(select(FederatedIdentity.subject)).scalars().all() == ["7"]


def test_issuer_and_subject_name_a_person_and_no_address_or_name_does(site: Site) -> None:
    site.client.post("/inscription", data={**FORM, "login": "ada@lycee.fr"})
    people = (("7", MOODLE), ("8", MOODLE), ("7", OTHER), ("ada@lycee.fr",))
    ids = {come(site, *who, name="Ada Lovelace").account.id for who in people}
    assert len(ids) == 4
    with site.database.read() as db:
        signed_up = db.execute(select(Account).where(Account.login == "ada@lycee.fr")).scalar_one()
    assert signed_up.id not in ids


def test_an_account_without_a_login_is_no_guest_and_passes_as_nobody(site: Site) -> None:
    """Its session alone erases nothing and makes no token, unless its school's system has just opened it."""
    opened = come(site)
    ada = browser(site, opened)
    age(site)
    assert "revenez d’abord par le système" in ada.post("/compte/supprimer", data={}).text
    assert "revenez d’abord" in ada.post("/compte/jetons", data={"label": "x", "password": ""}).text
    assert ada.post("/compte/mot-de-passe", data={"password": "", "new_password": "un autre mot"}).status_code == 404
    with site.database.read() as db, pytest.raises(Conflict):
        links.create_reset_link(db, str(opened.account.id), site.settings)
    ada = browser(site, come(site))
    assert 'id="jeton">' in ada.post("/compte/jetons", data={"label": "x", "password": ""}).text
    page = ada.get("/compte").text
    assert "Mot de passe actuel" not in page
    assert MOODLE in page
    assert ada.post("/compte/supprimer", data={}).headers["location"] == "/compte/efface"
    with site.database.read() as db:
        assert db.execute(select(FederatedIdentity)).first() is None


def test_an_administrator_and_a_suspended_account_are_not_opened_by_an_identity(site: Site) -> None:
    opened = come(site)
    for values in ({"role": Role.administrator}, {"role": Role.student, "disabled_at": utc_now()}):
        with site.database.write() as db:
            db.execute(update(Account).where(Account.id == opened.account.id).values(**values))
        with pytest.raises(Forbidden):
            come(site)


def test_a_pseudonym_is_worded_by_its_owner_and_replaced_by_a_name_that_is_told(site: Site) -> None:
    ada = browser(site, come(site))
    assert "Élève " in ada.get("/compte").text
    assert ada.post("/compte/nom", data={"name": "  Hypatie "}).status_code == 303
    assert "Hypatie" in ada.get("/compte").text
    assert "1 à 100" in ada.post("/compte/nom", data={"name": "x" * 101}).text
    assert come(site, name="Ada Lovelace").account.name == "Ada Lovelace"
    assert ada.post("/compte/nom", data={"name": "Hypatie"}).status_code == 409


def test_two_accounts_are_joined_on_a_page_that_names_both_by_the_password(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    site.client.cookies.clear()
    ada = browser(site, come(site, name="A. Lovelace"))
    ada.post("/l20/exercices/poses/soumissions", data={"code": "x = 1"})
    page = ada.get("/compte/rejoindre?identifiant=ada&suite=/l20").text
    assert "moodle.example" in page
    assert "A. Lovelace" in page
    assert "«&nbsp;<strong>ada</strong>" in page
    proof = {"login": "ada", "password": FORM["password"], "suite": "//evil.example"}
    assert "incorrect" in ada.post("/compte/rejoindre", data={**proof, "password": "autre"}).text
    joined = ada.post("/compte/rejoindre", data=proof)
    assert joined.headers["location"] == "/"
    with site.database.read() as db:
        (account,) = db.execute(select(Account)).scalars()
        assert account.login == "ada"
        assert db.execute(select(Submission.account_id)).scalars().all() == [account.id]
    again = come(site)
    assert again.account.id == account.id
    with zipfile.ZipFile(io.BytesIO(browser(site, again).get("/compte/donnees").content)) as files:
        (known,) = json.loads(files.read("compte.json"))["identities"]
    assert (known["issuer"], known["subject"]) == (MOODLE, "7")


@pytest.mark.parametrize("why", ["stale", "guest", "password", "administrator", "same system", "teaches", "sat twice"])
def test_accounts_that_are_not_joined(site: Site, why: str) -> None:
    site.client.post("/inscription", data=FORM)
    site.client.cookies.clear()
    with site.database.read() as db:
        target = db.execute(select(Account)).scalar_one()
    opened = come(site)
    martin = person(site, Role.teacher, "Mme Martin").account
    made = new_class(site.database, martin)
    client = browser(site, opened)
    with site.database.write() as db:
        if why == "administrator":
            db.execute(update(Account).where(Account.id == target.id).values(role=Role.administrator))
        if why == "password":
            db.execute(update(Account).where(Account.id == opened.account.id).values(login="other"))
        if why == "guest":
            db.execute(update(Account).where(Account.id == opened.account.id).values(role=Role.guest))
        if why == "same system":
            db.add(FederatedIdentity(account_id=target.id, issuer=MOODLE, subject="8"))
        if why == "teaches":
            db.add(Membership(class_id=made.id, account_id=opened.account.id, role="teacher"))
    if why == "sat twice":
        test = assign(site.database, made, EXERCISE, mode="test", duration_minutes=60)
        with site.database.write() as db:
            db.execute(update(Membership).values(is_confirmed=True))
        for account in (target, opened.account):
            seat(site.database, made, account)
            seated = client if account is opened.account else person(site, account=account).browser(site)
            assert seated.post(f"/classes/{made.id}/devoirs/{test.id}/commencer").status_code == 303
    if why == "stale":
        age(site)
    answer = client.post("/compte/rejoindre", data={"login": "ada", "password": FORM["password"]})
    assert answer.status_code in {403, 409, 422}
    with site.database.read() as db:
        assert db.get(Account, opened.account.id) is not None


def test_a_frame_has_a_session_of_its_own_in_a_partitioned_cookie(site: Site) -> None:
    with site.database.write() as db:
        opened = joining.open_identity_session(site.accounts, db, ExternalPerson(MOODLE, "7"), None, frames=MOODLE)
    assert opened.is_framed
    framed = {"cookie": f"{FRAMED_COOKIE}={opened.token}"}
    assert "Élève " in site.client.get("/compte", headers=framed).text
    mine = browser(site, come(site, "8", name="Grace"))
    page = mine.get("/compte", headers={"cookie": f"{SESSION_COOKIE}={come(site, '8').token}; {framed['cookie']}"})
    assert "Grace" in page.text, "the page's own session goes first"
    answer = site.client.post("/deconnexion", headers=framed)
    cookies = answer.headers.get_list("set-cookie")
    assert f"{FRAMED_COOKIE}=; Max-Age=0; Path=/; HttpOnly; Secure; SameSite=None; Partitioned" in cookies


def test_an_account_without_a_login_is_named_by_its_id_to_administrators(site: Site) -> None:
    opened = come(site, name="Ada")
    with site.database.read() as db:
        assert links.find_account_by_login_or_id(db, str(opened.account.id)).id == opened.account.id
        with pytest.raises(NotFound):
            links.find_account_by_login_or_id(db, str(uuid4()))
