"""Who logs in or signs up from a page comes back to it, and never goes to another site."""

from __future__ import annotations

import re
from urllib.parse import parse_qs, urlsplit

import pytest

from tests.support.service import Site

FORM = {"name": "Ada L.", "login": "ada", "password": "notes sur la machine"}
PAGE = "/l20/exercices/poses"


def suite(page: str, form: str) -> str:
    """Where the page's own link to a form says to come back to."""
    links = [link.replace("&amp;", "&") for link in re.findall(rf'href="(/{form}[^"]*)"', page)]
    assert links
    assert len(set(links)) == 1, "all links to it say the same"
    return parse_qs(urlsplit(links[0]).query).get("suite", ["/"])[0]


def hidden(page: str) -> str:
    found = re.search(r'name="suite" value="([^"]*)"', page)
    assert found
    return found[1].replace("&amp;", "&")


@pytest.mark.parametrize("path", [PAGE, f"{PAGE}/essais?page=1", "/l20/recherche?q=a%26b+c", "/l20", "/"])
def test_every_page_s_link_comes_back_to_it(site: Site, path: str) -> None:
    assert suite(site.client.get(path).text, "connexion") == path


def test_a_guest_comes_back_to_the_exercise_with_the_work(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    site.client.post("/deconnexion")
    sent = site.client.post(f"{PAGE}/soumissions", data={"code": "pass"}, headers={"Accept": "application/json"}).json()
    site.worker.run_one()
    assert suite(site.client.get(sent["verdict"]).text, "inscription") == PAGE, "the header that comes with a verdict"
    to_sign_up = site.client.get(f"/inscription?suite={suite(site.client.get(PAGE).text, 'inscription')}").text
    assert hidden(to_sign_up) == PAGE
    to_log_in = site.client.get(f"/connexion?suite={suite(to_sign_up, 'connexion')}").text
    assert hidden(to_log_in) == suite(to_log_in, "inscription") == PAGE
    wrong = site.client.post("/connexion", data={**FORM, "password": "au hasard", "suite": hidden(to_log_in)})
    answer = site.client.post("/connexion", data={**FORM, "suite": hidden(wrong.text)})
    assert (answer.status_code, answer.headers["location"]) == (303, PAGE)
    assert f'href="/soumissions/{sent["id"]}"' in site.client.get(PAGE).text


ELSEWHERE = [
    "https://evil.example/", "//evil.example", "/\\evil.example", "\\\\evil.example", "javascript:alert(1)", "evil",
    "/\t/evil.example", "/\n/evil.example", " //evil.example", "///evil.example", "http:evil.example", "/x\r\nX: y",
]  # fmt: skip


@pytest.mark.parametrize("after", ELSEWHERE)
@pytest.mark.parametrize("form", ["connexion", "inscription"])
def test_nobody_is_sent_to_another_site(site: Site, form: str, after: str) -> None:
    assert hidden(site.client.get(f"/{form}", params={"suite": after}).text) == "/"


def test_neither_by_what_is_sent(site: Site) -> None:
    site.client.post("/inscription", data=FORM)
    site.tighten(login_burst=100)
    for after in ELSEWHERE:
        assert site.client.post("/connexion", data={**FORM, "suite": after}).headers["location"] == "/", after
