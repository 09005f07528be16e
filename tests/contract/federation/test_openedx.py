"""Open edX's own code of LTI 1.3 (`lti-consumer-xblock`): launch, choice of a content, list and marks.

It is in an environment of its own, which `.ci/peers` makes; where it is absent, this test is skipped.
"""

from __future__ import annotations

import html
import json
import re
from collections.abc import Mapping
from datetime import timedelta
from http.cookiejar import CookieJar, DefaultCookiePolicy
from pathlib import Path
from typing import Any
from uuid import UUID

import httpx2 as httpx
import pytest
from sqlalchemy import delete, func, select

from server.assignments.models import AssignedExercise, Assignment
from server.base.settings import Settings
from server.classes.models import Membership
from server.course import Course
from server.database import Database, utc_now
from server.federation.errors import OutgoingError
from server.federation.lti import registration
from server.federation.lti.access_tokens import AccessTokenCache
from server.federation.lti.grade_services import GradeServices, Score
from server.federation.models import IdentityProvider, LineItem, MarkDelivery, ProviderContext
from server.federation.outbox_task import CourseMarksWork, SchoolMarksTask
from server.federation.outgoing import Outgoing, parse_networks
from server.identity.models import FederatedIdentity
from server.marks.models import Override
from tests.support.live import PATIENCE
from tests.support.peers import PEERS, TRIES, free_port, read, running, seconds
from tests.support.served import Server
from tests.support.service import EXERCISE

HERE, PYTHON = Path(__file__).parent, PEERS / "openedx" / "bin" / "python"
STUDENTS = 130  # of the course, as the peer has them


class Browser(httpx.Client):
    """A browser, for which this machine is as good as https."""

    def __init__(self) -> None:
        cookies = CookieJar(DefaultCookiePolicy(secure_protocols=("http", "https")))
        super().__init__(cookies=cookies, follow_redirects=True, timeout=PATIENCE)


class OpenEdx:
    """The platform, and its course as Balise has it."""

    def __init__(self, address: str, live: Server, data: Path) -> None:
        self.address, self.live = address, live
        self.database = Database(Settings(data_dir=data).sqlalchemy_url)
        self.outgoing = Outgoing(parse_networks("127.0.0.0/8"), insecure=True)
        self.provider = self._register(httpx.get(f"{address}/description", timeout=PATIENCE).json())

    def _register(self, told: Mapping[str, str]) -> IdentityProvider:
        """Register the platform with the addresses that Studio shows."""
        form = {
            "name": "Open edX",
            "issuer": told["issuer"],
            "client_id": told["client_id"],
            "authorization_url": told["oidc_callback"],
            "token_url": told["token_url"],
            "keys_url": told["keyset_url"],
            "deployments": told["deployment_id"],
        }
        texts, settings = registration.parse_form(form, insecure=True)
        with self.database.write() as db:
            return registration.add_platform(db, texts, settings, None)

    def arrive(self, browser: Browser, person: str, query: str = "") -> tuple[str, dict[str, str]]:
        """Begin a launch, and return what the platform has the browser send, and where."""
        page = browser.get(f"{self.address}/open/{person}{query}")
        assert page.status_code == 200, page.text
        (action,) = re.findall(r'action="([^"]*)"', page.text)
        return html.unescape(action), dict(re.findall(r'<input name="(\w+)" value="([^"]*)"', page.text))

    def launch(self, browser: Browser, person: str, query: str = "") -> httpx.Response:
        action, form = self.arrive(browser, person, query)
        return browser.post(action, data=form, headers={"Origin": self.address})

    def choose(self, browser: Browser, assignment: Assignment) -> Mapping[str, Any]:
        """Choose an assignment as the content of the component, and return the link that the platform has made."""
        choosing = self.launch(browser, "prof", "?choose")
        choice = {"etat": choosing.url.params["etat"], "contenu": str(assignment.id), "action": "ajouter"}
        page = browser.post(f"{self.live.address}/lti/contenu", data=choice).text
        found = re.search(r'action="(http[^"]+)">\s*<input type="hidden" name="JWT" value="([^"]+)"', page)
        assert found, page
        assert browser.post(found[1], data={"JWT": found[2]}).status_code == 200
        (link,) = json.loads(browser.get(f"{self.address}/description").json()["deep_linking_content_items"])
        return dict(link)

    def read_list(self, browser: Browser, class_id: UUID) -> int:
        """Take the list of the course into the class, and return how many enter by it."""
        form, address = {"cours": str(self.context.id)}, f"{self.live.address}/classes/{class_id}/plateforme/liste"
        shown = browser.post(address, data=form).text.replace("\xa0", " ")
        found, digest = re.search(r"(\d+) personnes entrent", shown), re.search(r'name="attendu" value="(\w+)"', shown)
        assert found, shown
        assert digest, shown
        browser.post(address, data={**form, "attendu": digest[1]})
        return int(found[1])

    @property
    def context(self) -> ProviderContext:
        with self.database.read() as db:
            return db.execute(select(ProviderContext).filter_by(provider_id=self.provider.id)).scalar_one()

    def enter_again(self, browser: Browser, person: str) -> float:
        """Launch once more, and return the seconds of the token's arrival."""
        action, form = self.arrive(browser, person)
        return seconds(lambda: browser.post(action, data=form, follow_redirects=False))

    def published(self) -> Mapping[str, list[float]]:
        return dict(httpx.get(f"{self.address}/published", timeout=PATIENCE).json())

    def assign(self, class_id: UUID) -> Assignment:
        """Give the class an assignment that is over."""
        now = utc_now()
        assignment = Assignment(
            class_id=class_id, title="DM 1", opens_at=now - timedelta(days=9), due_at=now - timedelta(days=1)
        )
        assignment.closes_at = assignment.due_at
        with self.database.write() as db:
            db.add(assignment)
            db.flush()
            db.add(AssignedExercise(assignment_id=assignment.id, exercise=EXERCISE, position=0))
        return assignment

    def mark(self, assignment: Assignment, person: str, points: float) -> None:
        with self.database.write() as db:
            row = db.execute(select(FederatedIdentity.account_id).filter_by(subject=person)).scalar_one()
            db.execute(delete(Override).where(Override.account_id == row))
            db.add(Override(
                class_id=assignment.class_id, account_id=row, assignment_id=assignment.id, exercise=EXERCISE,
                points=points, reason="x", based_on=[],
            ))  # fmt: skip

    def send(self, course: Course) -> None:
        SchoolMarksTask(self.database, course, self.outgoing).run(CourseMarksWork(self.context, self.provider))

    def score(self, **changes: Any) -> None:
        """Send a score as our services do. Raises OutgoingError."""
        with self.database.read() as db:
            (item,) = db.execute(select(LineItem)).scalars()
        assert item.url
        services = GradeServices(AccessTokenCache(self.database, self.outgoing), self.provider)
        services.post_score(item.url, Score(**{"subject": "s9", "points": 10.0, "at": utc_now(), **changes}))


@pytest.mark.skipif(not PYTHON.exists(), reason="lti-consumer-xblock is not here: .ci/peers")
def test_a_course_of_open_edx_has_its_people_its_link_and_its_marks(
    live: Server, data: Path, by_password: dict[str, str], tmp_path: Path, course: Course
) -> None:
    port = free_port()
    address = f"http://127.0.0.1:{port}"
    command = [str(PYTHON), str(HERE / "openedx_peer.py"), str(tmp_path), str(port), live.address]
    with running(command, f"{address}/published"), Browser() as teacher, Browser() as student:
        openedx = OpenEdx(address, live, data)
        page = openedx.launch(teacher, "prof")
        assert "/etablissement/cours/" in str(page.url), page.text
        assert "Robotique" in page.text
        made = teacher.post(str(page.url), data={"action": "creer", "name": "MPSI", "module": "l20"})
        found = re.search(r"/classes/([0-9a-f-]{36})$", str(made.url))
        assert found, made.text
        assignment = openedx.assign(UUID(found[1]))

        assert teacher.get(f"{address}/open/s1?choose").status_code == 403
        chosen = openedx.choose(teacher, assignment)
        assert chosen["url"] == f"{live.address}/classes/{assignment.class_id}/devoirs/{assignment.id}"
        action, form = openedx.arrive(student, "s1")
        opened = student.post(action, data=form)
        assert (opened.url.fragment, "Nom s1" in opened.text) == (f"devoir-{assignment.id}", True)
        assert student.post(action, data=form).status_code == 403
        openedx.launch(student, "s2")

        assert openedx.read_list(teacher, assignment.class_id) == STUDENTS - 2
        seats = select(func.count()).select_from(Membership).where(Membership.class_id == assignment.class_id)
        assert read(data, seats) == [STUDENTS + 1]

        openedx.mark(assignment, "s1", 15)
        openedx.mark(assignment, "s2", 0)
        openedx.send(course)
        assert openedx.published() == {"s1": [0.75], "s2": [0.0]}
        openedx.mark(assignment, "s1", 16)
        openedx.send(course)
        assert openedx.published() == {"s1": [0.75, 0.8], "s2": [0.0]}
        assert {row.state for row in read(data, select(MarkDelivery))} == {"sent"}
        openedx.score(points=25.0)
        assert openedx.published()["s9"] == [1.0]
        for wrong, status in (({"at": utc_now() - timedelta(days=1)}, 400), ({"points": -1.0}, 500)):
            with pytest.raises(OutgoingError) as refused:
                openedx.score(**wrong)
            assert refused.value.status == status, wrong

        sign_in = f"{live.address}/connexion"
        typed = min(seconds(lambda: httpx.post(sign_in, data=by_password)) for _ in range(TRIES))
        launched = min(openedx.enter_again(student, "s1") for _ in range(TRIES))
        assert launched < typed, "a launch takes longer than a sign-in by a password"
    openedx.database.engine.dispose()
