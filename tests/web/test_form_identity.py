"""A form is accepted for the account for which its page was drawn, and for no other."""

from __future__ import annotations

import html
import re
from typing import Any

import pytest
from sqlalchemy import delete, func, select

from server.base.http import SESSION_COOKIE
from server.identity.models import Account, BrowserSession
from server.submissions.models import Submission
from server.web.form_identity import decode_resent_fields, insert_account_key_in_forms
from tests.support.classes import Person, person
from tests.support.client import TestClient
from tests.support.forms import hidden_fields
from tests.support.service import EXERCISE, Site

PAGE = f"/{EXERCISE.replace('/', '/exercices/')}"
SEND = f"{PAGE}/soumissions"
JSON = {"Accept": "application/json"}
CODE = 'def f(x):\n    return "<é>"\n'


def end_sessions(site: Site, who: Person) -> None:
    with site.database.write() as db:
        db.execute(delete(BrowserSession).where(BrowserSession.account_id == who.id))


def count(site: Site, model: Any) -> int:
    with site.database.read() as db:
        return db.scalar(select(func.count()).select_from(model)) or 0


def submitters(site: Site) -> list[Any]:
    with site.database.read() as db:
        return list(db.scalars(select(Submission.account_id)))


@pytest.fixture
def xavier(site: Site) -> Person:
    return person(site, name="Xavier")


def test_every_form_of_a_page_names_its_account(site: Site, xavier: Person) -> None:
    page = xavier.browser(site).get(PAGE).text
    forms = len(re.findall(r'<form\b[^>]*method="post"', page))
    assert forms >= 2
    assert page.count(f'name="pour" value="{xavier.id}"') == forms
    assert hidden_fields(site.client.get(PAGE).text, SEND)["pour"] == "visiteur"


def test_only_forms_that_post_to_us_are_marked() -> None:
    page = '<form role="search" action="/q"><p>&lt;form method="post"&gt;</p></form><form method="post" class="a">'
    away = '<form method="post" action="https://moodle.example/retour">'
    assert insert_account_key_in_forms(away, "a") == away
    assert insert_account_key_in_forms(page, 'a"b') == page + '<input type="hidden" name="pour" value="a&#34;b">'


@pytest.mark.parametrize("cookie", ["dead", "none"])
def test_a_form_whose_session_has_ended_is_no_guests(site: Site, xavier: Person, cookie: str) -> None:
    browser = xavier.browser(site)
    fields = hidden_fields(browser.get(PAGE).text, SEND)
    end_sessions(site, xavier)
    if cookie == "none":
        browser.cookies.clear()
    accounts, sent = count(site, Account), count(site, Submission)
    refused = browser.post(SEND, data={**fields, "code": CODE})
    assert refused.status_code == 401
    assert "Vous n’êtes plus connecté" in refused.text
    assert html.escape(CODE, quote=False) in refused.text.replace("&#34;", '"')
    as_json = browser.post(SEND, data={**fields, "code": CODE}, headers=JSON)
    assert as_json.status_code == 401
    assert as_json.json()["type"].endswith("session-terminee")
    assert as_json.json()["login"].startswith("/connexion?suite=")
    assert (count(site, Account), count(site, Submission)) == (accounts, sent)


def test_a_dead_session_makes_no_guest_even_without_the_field(site: Site, xavier: Person) -> None:
    browser = xavier.browser(site)
    end_sessions(site, xavier)
    assert browser.post(SEND, data={"code": CODE}).status_code == 401
    assert browser.post(f"{PAGE}/brouillon", data={"code": CODE}).status_code == 401


def test_logging_in_on_the_refusal_gives_back_what_was_typed(site: Site) -> None:
    browser = TestClient(site.app, follow_redirects=False)
    fields = {"name": "Zoé", "login": "zoe.form", "password": "une phrase secrète"}
    assert browser.post("/inscription", data=fields).status_code == 303
    drawn = hidden_fields(browser.get(PAGE).text, SEND)
    browser.cookies.clear()
    refused = browser.post(SEND, data={**drawn, "code": CODE}, headers={"Referer": f"http://testserver{PAGE}"}).text
    login = hidden_fields(refused, "/connexion")
    assert login["suite"] == PAGE

    wrong = browser.post("/connexion", data={**login, "login": "zoe.form", "password": "autre chose"})
    assert wrong.status_code == 422
    login = hidden_fields(wrong.text, "/connexion")
    ready = browser.post("/connexion", data={**login, "login": "zoe.form", "password": fields["password"]})
    assert ready.status_code == 200
    assert "Envoyer au nom de « Zoé »" in ready.text
    again = hidden_fields(ready.text, SEND)
    assert again["code"] == CODE
    before = count(site, Submission)
    assert browser.post(SEND, data=again).status_code == 303
    assert count(site, Submission) == before + 1


def test_a_pasted_list_is_kept_where_no_file_was_chosen(site: Site, xavier: Person) -> None:
    """A browser sends the empty field of a file too."""
    browser = xavier.browser(site)
    pour = hidden_fields(browser.get(PAGE).text, SEND)["pour"]
    end_sessions(site, xavier)
    parts = [f'name="pour"\r\n\r\n{pour}', f'name="code"\r\n\r\n{CODE}', 'name="fichier"; filename=""\r\n\r\n']
    body = "".join(f"--limite\r\nContent-Disposition: form-data; {part}\r\n" for part in parts) + "--limite--\r\n"
    form = {"Content-Type": "multipart/form-data; boundary=limite"}
    refused = browser.post(SEND, content=body.encode(), headers=form)
    assert refused.status_code == 401
    assert "Le fichier joint" not in refused.text
    assert decode_resent_fields(hidden_fields(refused.text, "/connexion")["reprise"]) == [("code", CODE)]
    chosen = {"fichier": ("liste.csv", b"nom", "text/csv")}
    assert "Le fichier joint n’a pas été gardé" in browser.post(SEND, data={"pour": pour}, files=chosen).text


def test_a_refused_form_leads_back_to_its_page(site: Site, xavier: Person) -> None:
    browser = xavier.browser(site)
    pour = hidden_fields(browser.get(PAGE).text, SEND)["pour"]
    back = {"Referer": f"http://testserver{PAGE}"}
    refused = browser.post(f"{SEND}-absent", data={"pour": pour}, headers=back)
    assert refused.status_code == 404
    assert f'href="{PAGE}">Revenir à la page</a>' in refused.text
    assert "Revenir à la page" not in browser.get("/nulle-part", headers=back).text


def test_two_accounts_in_one_browser_do_not_send_for_each_other(site: Site, xavier: Person) -> None:
    yasmine = person(site, name="Yasmine")
    drawn = hidden_fields(xavier.browser(site).get(PAGE).text, SEND)
    browser = yasmine.browser(site)
    refused = browser.post(SEND, data={**drawn, "code": CODE})
    assert refused.status_code == 409
    assert "vous êtes maintenant « Yasmine »" in refused.text
    assert not {xavier.id, yasmine.id} & set(submitters(site))
    problem = browser.post(SEND, data={"code": CODE}, headers={**JSON, "Balise-Compte": str(xavier.id)}).json()
    assert (problem["account"], problem["button"]) == (str(yasmine.id), "Envoyer au nom de « Yasmine »")
    assert browser.post(SEND, data=hidden_fields(refused.text, SEND)).status_code == 303  # chosen, in words
    assert submitters(site).count(yasmine.id) == 1


def test_a_visitor_who_became_a_guest_in_another_tab_is_the_same_person(site: Site) -> None:
    browser = TestClient(site.app, follow_redirects=False)
    fields = hidden_fields(browser.get(PAGE).text, SEND)
    assert browser.post(SEND, data={**fields, "code": CODE}).status_code == 303
    assert SESSION_COOKIE in browser.cookies
    assert browser.post(SEND, data={**fields, "code": CODE + "# 2"}).status_code == 303


def test_a_visitors_page_does_not_send_for_who_has_logged_in_since(site: Site, xavier: Person) -> None:
    fields = hidden_fields(site.client.get(PAGE).text, SEND)
    assert xavier.browser(site).post(SEND, data={**fields, "code": CODE}).status_code == 409


def test_who_was_signed_out_may_send_as_a_guest_when_told_so(site: Site, xavier: Person) -> None:
    browser = xavier.browser(site)
    fields = hidden_fields(browser.get(PAGE).text, SEND)
    end_sessions(site, xavier)
    refused = browser.post(SEND, data={**fields, "code": CODE}).text
    assert "Envoyer comme invité" in refused
    assert browser.post(SEND, data=hidden_fields(refused, SEND)).status_code == 303


@pytest.mark.parametrize("text", ["", "{", "[1]", '[["a"]]', '[["a", 1]]', '{"a": "b"}', "[" * 100_000])
def test_resent_fields_that_are_no_fields_are_nothing(text: str) -> None:
    assert decode_resent_fields(text) is None


def test_passwords_are_not_sent_again() -> None:
    assert decode_resent_fields('[["password", "x"], ["code", "y"]]') == [("code", "y")]


def test_a_request_that_is_cut_off_is_no_request(site: Site, xavier: Person) -> None:
    """The body's end never comes: the client has gone."""
    messages = iter(
        [
            {"type": "http.request", "body": b"code=x+%3D+1", "more_body": True},
            {"type": "http.disconnect"},
        ]
    )
    answers: list[Any] = []

    async def receive() -> Any:
        return next(messages)

    async def send(message: Any) -> None:
        answers.append(message)

    cookie = f"{SESSION_COOKIE}={xavier.cookies[SESSION_COOKIE]}".encode()
    headers = [(b"host", b"testserver"), (b"cookie", cookie), (b"content-type", b"application/x-www-form-urlencoded")]
    scope = {
        "type": "http", "method": "POST", "path": SEND, "raw_path": SEND.encode(), "query_string": b"",
        "headers": headers, "scheme": "http", "server": ("testserver", 80), "client": ("testclient", 1),
        "http_version": "1.1", "root_path": "", "asgi": {"version": "3.0"},
    }  # fmt: skip
    with site.client._portal_factory() as portal:
        portal.call(site.app, scope, receive, send)
    assert answers[0]["status"] == 422
    assert xavier.id not in submitters(site)
