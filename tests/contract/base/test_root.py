"""Behind a proxy that gives the service a part of its site only: nothing that goes out leads elsewhere."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
from pydantic import ValidationError

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Verdict
from server.assignments.models import Mode
from server.base import root_path
from server.base.app_services import get_service
from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.board.live import LiveClassViews
from server.database import Database
from server.figures.service import FigureService
from server.grading.grading_task import GradingInput
from server.identity.models import Role
from tests.contract.rights.test_routes import FORMS, Drawer, Stage, expected
from tests.support.classes import assign, new_class, person, seat
from tests.support.client import TestClient
from tests.support.service import EXERCISE, Site

ROOT = "/balise"
#: What may begin with a slash without being an address: what somebody wrote, and where to go after a form, inside.
TEXTS = {"value", "title", "alt", "content", "placeholder", "aria-label", "label"}
#: Members of JSON that hold a place inside of a document.
POINTERS = {"pointer"}
#: No array of numbers in base 64, as scenes of replays have them.
ADDRESS = re.compile(r"/(?![A-Za-z0-9+/=]{60})")


@pytest.fixture
def settings(tmp_path: Path) -> Iterator[Settings]:
    yield Settings(data_dir=tmp_path / "data", workers=0, root_path=ROOT, guest_burst=10_000, sign_up_burst=1000)
    root_path.set_root_path("")


class Addresses(HTMLParser):
    """All that a page says that begins with a slash, but for its texts."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.found: list[str] = []
        self.attributes: set[str] = set()
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if value and value.startswith("/") and name not in TEXTS:
                self.found.append(value)
                self.attributes.add(name)
            if value and "url(/" in value:
                self.found.append(value.partition("url(")[2])


def in_json(value: Any, key: str = "") -> Iterator[str]:
    if isinstance(value, dict):
        for name, one in value.items():
            yield from in_json(one, name)
    elif isinstance(value, list):
        for one in value:
            yield from in_json(one, key)
    elif isinstance(value, str):
        yield from Addresses(value).found if "<" in value else ()
        if ADDRESS.match(value) and key not in POINTERS:
            yield value


def in_events(text: str) -> Iterator[str]:
    for line in text.splitlines():
        said = line.removeprefix("data:").strip()
        yield from in_json(json.loads(said)) if said.startswith("{") else Addresses(said).found


def addresses(answer: Any, page: Addresses | None) -> list[str]:
    """Return what an answer says, and its headers, that begins with a slash; `page` is its text where it is HTML."""
    kind = answer.headers.get("content-type", "").partition(";")[0]
    found = [answer.headers[name] for name in ("location", "content-location") if name in answer.headers]
    found += re.findall(r"Path=([^;]*)", answer.headers.get("set-cookie", ""))
    if page is not None:
        found += page.found
    elif kind.endswith("json") and answer.text[:1] in "[{":  # the drawer of these tests draws nothing
        described = answer.json()
        found += in_json({**described, "paths": None, "components": None} if "openapi" in described else described)
    elif kind == "text/event-stream":
        found += in_events(answer.text)
    elif kind in {"text/javascript", "text/css", "image/svg+xml"} and "/static/" not in str(answer.url):
        found += re.findall(r"""(?:from |import\(?|fetch\(|url\()["'`]?(/\w[^"'`)]*)""", answer.text)
    return found


def astray(found: list[str]) -> list[str]:
    inside = re.compile(rf"{ROOT}(?!{ROOT})(?:[/?#].*)?", re.DOTALL)
    return [one for one in found if not inside.fullmatch(one)]


class Watched(TestClient):
    """Asks under the path, as a proxy that leaves it there; remembers what has led elsewhere, and how much was seen."""

    def __init__(self, app: Any, **options: Any) -> None:
        super().__init__(app, follow_redirects=False, **options)
        self.seen: list[str] = []
        self.attributes: set[str] = set()
        self.strays: set[tuple[str, str]] = set()

    def request(self, method: str, url: Any, **options: Any) -> Any:
        answer = super().request(method, f"{ROOT}{str(url).removeprefix(ROOT)}", **options)
        is_page = answer.headers.get("content-type", "").startswith("text/html")
        page = Addresses(answer.text) if is_page else None
        found = [address for address in addresses(answer, page) if not re.match(SCHOOL, str(url))]
        self.seen += found
        self.strays |= {(f"{method} {url}", one) for one in astray(found)}
        if page is not None:
            self.attributes |= page.attributes
        return answer


#: It leads to the school's server on purpose.
SCHOOL = "/connexion/etablissement/[^/]*$"


def pages(table: dict[str, Any]) -> list[str]:
    """What is looked at with a browser, but for what reads the whole course at first."""
    return [name for name in table if name.startswith("GET ") and "/api/" not in name and "recherche" not in name]


def everything(table: dict[str, Any]) -> list[str]:
    asked = [name for name in table if name.startswith("GET ")]
    return asked + [name for name in FORMS if not re.search("effacer|archiver|eleves$", name)]


@pytest.mark.parametrize(
    ("asked", "people"),
    [(pages, ("teacher",)), pytest.param(everything, ("student", "visitor", "teacher"), marks=pytest.mark.slow)],
    ids=["pages", "everything"],
)
def test_nothing_of_any_route_leads_out_of_the_path(site: Site, asked: Any, people: tuple[str, ...]) -> None:
    """Every route that the table of rights knows."""
    get_service(site.app, FigureService).pictures._drawer = Drawer()  # type: ignore[assignment]
    get_service(site.app, LiveClassViews).max_stream_seconds = 0.0
    client = Watched(site.app)
    stage = Stage(Site(site.app, client, site.settings))
    for name in asked(expected()):
        for who in people:
            stage.ask(name, who)
    assert client.strays == set()
    assert len(client.seen) > 1000
    assert {one.removeprefix(ROOT) for one in client.seen} >= {"/", "/classes", "/compte", "/l20/lire/localiser"}
    assert client.attributes <= set(root_path.ATTRIBUTES)
    assert client.attributes >= {"href", "src", "action", "data-action", "data-hands", "data-answers", "data-stream"}


def wrong(sent: GradingInput) -> Judgement:
    check = CheckResult("a", "Première", False, 0, 20, "On attend 4.", figure="a")
    return Judgement(Verdict(EXERCISE, "v1", Outcome.WRONG_ANSWER, sent.seed, [check]), {"a": {"kind": "fake"}})


def test_nor_does_what_is_looked_at_while_something_goes_on(site: Site) -> None:
    """A verdict that is waited for, then read; a test that is sat; a regrade that advances; what scripts are told."""
    teacher, ada = person(site, Role.teacher), person(site)
    made = new_class(site.database, teacher.account)
    seat(site.database, made, ada.account)
    sitting = assign(site.database, made, "l20/odometrie", mode=Mode.test, duration_minutes=30)
    student, mine = Watched(site.app, cookies=ada.cookies), Watched(site.app, cookies=teacher.cookies)
    page, asks_json = f"/{EXERCISE.replace('/', '/exercices/')}", {"Accept": "application/json"}
    sent = student.post(f"{page}/soumissions", data={"code": "x = 1"}, headers=asks_json).json()
    student.get(sent["page"])
    student.get(page)
    assert site.worker_with(wrong).run_one()
    for one in (sent["page"], sent["verdict"], sent["events"], page):
        assert student.get(one).status_code == 200, one
    assert student.post(f"/classes/{made.id}/devoirs/{sitting.id}/commencer").status_code == 303
    assert student.get("/l20/exercices/odometrie").status_code == 200
    sent_by_program = student.post("/api/v1/submissions", json={"exercise": EXERCISE, "code": "x"}, headers=ada.headers)
    assert sent_by_program.headers["location"] == sent_by_program.json()["url"]
    begun = mine.post(f"/classes/{made.id}/recalculs", data={"exercice": EXERCISE})
    assert mine.get(begun.headers["location"]).status_code == 200
    assert student.strays | mine.strays == set()
    met = {"data-events", "data-verdict", "data-save", "formaction", "srcset", "data-progress"}
    assert student.attributes | mine.attributes >= met


def test_the_path_is_taken_off_where_the_proxy_has_left_it_and_where_it_has_not(site: Site) -> None:
    for there in ("/balise/connexion", "/connexion"):
        assert 'action="/balise/connexion"' in site.client.get(there).text
    assert site.client.get("/balise").status_code == site.client.get("/balise/").status_code == 200
    assert site.client.get("/balisepoint").status_code == 404
    gone = site.client.get("/balise/rien", headers={"Accept": "application/json"})
    assert (gone.status_code, gone.json()["instance"]) == (404, "/balise/rien")
    assert site.client.get("/balise/healthz").status_code == site.client.get("/healthz").status_code == 200
    assert site.client.get("/api/v1/openapi.json").json()["servers"] == [{"url": ROOT}]


def test_a_slash_too_many_does_not_lead_out_of_the_path(site: Site) -> None:
    for there in ("/balise/classes/", "/classes/"):
        assert site.client.get(there).headers["location"] == "/balise/classes"
    assert site.client.get("/l20/lire/localiser/?ouvrir=oui").headers["location"] == (
        "/balise/l20/lire/localiser?ouvrir=oui"
    )


def test_our_own_failure_is_told_as_elsewhere_and_its_address_in_no_log(
    site: Site, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """An address may hold a one-time link; a program that asks the API gets no page."""

    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("ours")

    client = TestClient(site.app, follow_redirects=False, raise_server_exceptions=False)
    monkeypatch.setattr(Database, "open_read_session", fail)
    page = client.get("/balise/l20/lire/le-secret-du-lien")
    assert page.status_code == 500
    assert "frame-ancestors 'none'" in page.headers["content-security-policy"]
    told = client.get("/balise/api/v1/exercises", headers={"Authorization": "Bearer x"})
    assert (told.status_code, told.headers["content-type"]) == (500, "application/problem+json")
    assert told.json()["instance"] == "/balise/api/v1/exercises"
    said = [record.getMessage() for record in caplog.records if record.name == "server.web.errors"]
    assert len(said) == 2
    assert not any("secret" in one for one in said)
    assert said[0].endswith("/{module:module}/lire/{slug}")


def test_one_logs_in_and_comes_back_and_the_cookie_is_of_the_path_alone(site: Site) -> None:
    form = {"name": "Ada", "login": "ada", "password": "une phrase assez longue", "suite": "/classes"}
    answer = site.client.post("/balise/inscription", data=form)
    assert answer.headers["location"] == "/balise/classes"
    assert "; Path=/balise;" in answer.headers["set-cookie"]
    asked = {**form, "suite": "//ailleurs.example"}
    assert site.client.post("/balise/connexion", data=asked).headers["location"] == "/balise/"
    left = site.client.post("/balise/deconnexion")
    assert "; Path=/balise;" in left.headers["set-cookie"]
    forged = site.client.post("/balise/connexion", data=form, headers={"Sec-Fetch-Site": "cross-site"})
    assert forged.status_code == 403


def test_of_two_sessions_that_of_the_nearest_path_counts(site: Site) -> None:
    """A service that has moved to a path left a cookie at the root, which browsers show last."""
    ada = person(site)
    shown = f"{SESSION_COOKIE}={ada.cookies[SESSION_COOKIE]}; {SESSION_COOKIE}=ce-que-la-racine-avait"
    assert "Se déconnecter" in site.client.get("/balise/compte", headers={"Cookie": shown}).text


def test_what_one_is_to_copy_has_the_whole_address(site: Site) -> None:
    form, host = {"label": "essai", "password": "une phrase assez longue"}, {"Host": "lycee.example"}
    site.client.post("/balise/inscription", data={"name": "Ada", "login": "ada", "password": form["password"]})
    account = site.client.post("/balise/compte/jetons", data=form, headers=host).text
    assert "balise login --server http://lycee.example/balise<" in account
    guide = site.client.get("/balise/docs", headers=host).text
    assert "http://lycee.example/balise/api/v1/submissions" in guide


@pytest.mark.parametrize("text", ["balise", "/a b", "/../x", "//x", "/é", "/a?b", '/"', "/.x"])
def test_what_is_no_path_is_refused(text: str) -> None:
    with pytest.raises(ValidationError):
        Settings(root_path=text)


@pytest.mark.parametrize(("text", "path"), [("", ""), ("/", ""), ("/balise/", "/balise"), ("/a/b-c", "/a/b-c")])
def test_a_path_may_end_with_a_slash(text: str, path: str) -> None:
    assert Settings(root_path=text).root_path == path


def test_without_a_path_a_page_is_left_as_it_is() -> None:
    root_path.set_root_path("")
    page = '<a href="/classes" title="/x">'
    assert root_path.with_external_paths(page) is page


def test_what_somebody_wrote_is_no_address() -> None:
    root_path.set_root_path(ROOT)
    said = (
        '<p title="/scan" data-key="/scan" href="//ailleurs/" src="https://x/"> href=&quot;/classes&quot; /classes</p>'
    )
    assert root_path.with_external_paths(said) == said
    assert root_path.with_external_paths('<a class="x" href="/">') == '<a class="x" href="/balise/">'
    root_path.set_root_path("")
