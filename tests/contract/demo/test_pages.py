"""Every page of a demonstration to which a link leads answers: for a visitor, a student and the teacher."""

from __future__ import annotations

import html
import re
from collections import deque
from dataclasses import dataclass
from typing import Any
from urllib.parse import parse_qs, urljoin, urlsplit

import pytest
from fastapi import FastAPI
from fastapi.routing import iter_route_contexts
from sqlalchemy import select

from graders.core.contract.findings import Judgement
from graders.core.contract.outcomes import Outcome
from graders.core.contract.verdict import CheckResult, Diagnosis, Verdict
from server.base.app_services import get_service
from server.base.settings import Settings
from server.course import Course
from server.demo.loading import TEACHER, choose_demo_module, create_demo_class
from server.figures.service import FigureService
from server.identity.models import Account
from tests.contract.rights.test_routes import Drawer
from tests.support.classes import person
from tests.support.service import Site
from tests.support.small_site import CHECK, PASSED

PUPILS = 4
#: Routes to which links lead at least: fewer, and the walk has ended early.
MIN_REACHED = {"visitor": 12, "student": 18, "teacher": 42}
#: What takes seconds, and has its own tests: an index of the whole course, archives.
LEFT_OUT = re.compile(r"/recherche|/hors-ligne|\.zip|/copies|/static/|/deconnexion|/evenements")


#: A link or a picture of a page, and where it leads: as our templates write both.
LINK = re.compile(r"<(?:a|img)\b[^>]*?\s(?:href|src)=([\"'])(.*?)\1", re.DOTALL)


def links(page: str) -> list[str]:
    """Return the addresses that a page's links and pictures lead to, on this site."""
    found = [html.unescape(address) for _, address in LINK.findall(page)]
    return [address for address in found if address and not re.match(r"\w+:|//|#", address)]


@dataclass(frozen=True)
class Crawl:
    """The routes that were reached, and the addresses that answered with a fault."""

    reached: set[str]
    faults: list[tuple[str, str, int]]


def grade(course: Course, exercise: str, source: bytes, seed: int) -> Judgement:
    """A verdict without a sandbox: right, or wrong with a counterexample and a mistake that has a name."""
    if b'print("ici' not in source:
        return Judgement(Verdict(exercise, "v1", Outcome.OK, seed, [PASSED]))
    mistake = Diagnosis(min(course.exercises[exercise].grader.mistake_ids()), "Une erreur", "Ainsi.")
    verdict = Verdict(exercise, "v1", Outcome.WRONG_ANSWER, seed, [CheckResult.from_json(CHECK)], diagnosis=mistake)
    return Judgement(verdict, figures={CHECK["figure"]: {"kind": "fake"}})


def patterns(app: FastAPI) -> list[tuple[str, re.Pattern[str]]]:
    """The path of each route that answers to GET, with what it matches; literal paths come before others."""
    paths = {route.path for route in iter_route_contexts(app.routes) if "GET" in (route.methods or ())}
    spelled = [(path, re.sub(r"\{\w+:path\}", ".+", path)) for path in sorted(paths, key=lambda path: path.count("{"))]
    return [(path, re.compile(re.sub(r"\{[\w:]+\}", "[^/]+", pattern))) for path, pattern in spelled]


def crawl(client: Any, routes: list[tuple[str, re.Pattern[str]]]) -> Crawl:
    """Follow links from the first page: of each route, one address for each set of names in its query."""
    queue, seen, result = deque([("/", "")]), set(), Crawl(set(), [])
    while queue:
        address, origin = queue.popleft()
        parts = urlsplit(address)
        if LEFT_OUT.search(parts.path):
            continue
        route = next((path for path, pattern in routes if pattern.fullmatch(parts.path)), parts.path)
        key = (route, tuple(sorted(parse_qs(parts.query))))
        if key in seen:
            continue
        seen.add(key)
        answer = client.get(address)
        if answer.status_code >= 400:
            result.faults.append((origin, address, answer.status_code))
        result.reached.add(route)
        found = [answer.headers["location"]] if "location" in answer.headers else []
        if answer.headers.get("content-type", "").startswith("text/html"):
            found += links(answer.text)
        queue.extend((urljoin(address, link), address) for link in found)
    return result


@pytest.fixture
def demo(site: Site, course: Course) -> Site:
    """A site with the class of a demonstration; nothing is drawn."""

    def judge(exercise: str, source: bytes, seed: int) -> Judgement:
        return grade(course, exercise, source, seed)

    get_service(site.app, FigureService).pictures._drawer = Drawer()  # type: ignore[assignment]
    create_demo_class(
        site.database,
        course,
        choose_demo_module(course),
        judge,
        Settings(),
        seed=3,
        students=PUPILS,
        report_progress=lambda *_: None,
    )
    return site


def test_no_link_of_a_demonstration_leads_to_a_fault(demo: Site) -> None:
    with demo.database.read() as db:
        accounts = {account.login: account for account in db.scalars(select(Account))}
    teacher = accounts.pop(TEACHER[0])
    student = next(account for account in accounts.values() if account.role == "student")
    routes = patterns(demo.app)
    reached = {}
    for name, account in {"visitor": None, "student": student, "teacher": teacher}.items():
        client = demo.client if account is None else person(demo, account=account).browser(demo)
        result = crawl(client, routes)
        assert result.faults == [], name
        reached[name] = result.reached
    assert {name: len(paths) >= MIN_REACHED[name] for name, paths in reached.items()} == dict.fromkeys(reached, True)
