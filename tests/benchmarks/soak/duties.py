"""The duties of a round: a test, a regrade, pages, files, a backup. One that fails is noted, and the soak goes on."""

from __future__ import annotations

import re
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from pathlib import Path
from uuid import UUID

import httpx
from sqlalchemy import select

from server.assignments.models import AssignedExercise, Assignment, Mode
from server.base.http import SESSION_COOKIE
from server.classes.models import SchoolClass
from server.database import Database, utc_now
from tests.benchmarks.crowd.plan import MODULE, Programs
from tests.benchmarks.crowd.service import Service
from tests.support.live import balise

PATIENCE = 600.0  # seconds: a longer wait is a failure
REGRADED = "poses"
TESTED = "boucles"  # none of the crowd's: an exercise of a test is sent in that test alone
PAGES = (
    "",
    "/seance",
    "/tableau",
    "/semaine",
    "/objectifs",
    "/conseil",
    "/carnet",
    "/eleves",
    "/devoirs",
    "/questions",
)
FILES = (
    "/carnet/fichier?format=xlsx",
    "/carnet/fichier?format=csv",
    "/carnet/copies",
    "/erreurs/fichier",
    "/journal/fichier",
)


class DutyError(Exception):
    """The service did not do what was asked."""


class Duties:
    """A teacher, some students who sit tests, and an administrator's backups."""

    def __init__(
        self,
        service: Service,
        folder: Path,
        board: tuple[str, str],
        testers: Sequence[str],
        programs: Mapping[str, Programs],
    ) -> None:
        self.service, self.folder, self.programs = service, folder, programs
        cookie, self.path = board
        self.teacher = self._client(cookie)
        self.testers = [self._client(tester) for tester in testers]
        self.round = 0
        self.done: Counter[str] = Counter()
        self.failures: list[str] = []

    def _client(self, cookie: str) -> httpx.Client:
        address = self.service.addresses[0]
        return httpx.Client(base_url=address, cookies={SESSION_COOKIE: cookie}, timeout=PATIENCE)

    def perform_all(self) -> None:
        self.round += 1
        for name, duty in DUTIES.items():
            try:
                duty(self)
                self.done[name] += 1
            except (DutyError, httpx.HTTPError, AssertionError) as error:
                self.failures.append(f"{name}: {type(error).__name__}: {error}")

    def read_pages(self) -> None:
        for page in PAGES:
            require(self.teacher.get(self.path + page), 200)

    def download_files(self) -> None:
        for file in FILES:
            require(self.teacher.get(self.path + file), 200)

    def sit_test(self) -> None:
        """A test is given; each student begins it, saves, sends and hands in; all is graded in the end."""
        path = f"{self.path}/devoirs/{self._assign_test()}"
        exercise = f"/{MODULE}/exercices/{TESTED}"
        for number, tester in enumerate(self.testers):
            code = f"{self.programs[TESTED].right}\ncontrole = {self.round}_{number}\n"
            require(tester.post(f"{path}/commencer"), 303)
            require(
                tester.post(f"{exercise}/brouillon", data={"code": code}, headers={"Accept": "application/json"}), 200
            )
            require(tester.post(f"{exercise}/soumissions", data={"code": code}), 303)
            require(tester.post(f"{path}/rendre"), 303)
        require(self.teacher.get(path), 200)

    def _assign_test(self) -> UUID:
        with closing(Database(self.service.url)) as database, database.write() as db:
            class_id = db.execute(select(SchoolClass.id).order_by(SchoolClass.created_at)).scalars().first()
            test = Assignment(
                class_id=class_id,
                title=f"Contrôle {self.round}",
                opens_at=utc_now(),
                mode=Mode.test,
                duration_minutes=60,
            )
            db.add(test)
            db.flush()
            db.add(AssignedExercise(assignment_id=test.id, exercise=f"{MODULE}/{TESTED}", position=0))
            return test.id

    def regrade(self) -> None:
        """What was sent to an exercise is graded anew, applied, and undone."""
        form = {"exercice": f"{MODULE}/{REGRADED}", "regle": "keep_best"}
        page = require(self.teacher.post(f"{self.path}/recalculs", data=form), 303).headers["location"]
        for action in ("appliquer", "annuler"):
            self._wait_for_action(page, action)
            require(self.teacher.post(page, data={"action": action}), 303)

    def _wait_for_action(self, page: str, action: str) -> None:
        deadline = time.monotonic() + PATIENCE
        while not re.search(rf'value="{action}"', require(self.teacher.get(page), 200).text):
            if time.monotonic() > deadline:
                raise DutyError(f"{page} does not offer {action}")
            time.sleep(1.0)

    def back_up(self) -> None:
        file = self.folder / f"backup-{self.round}"
        result = balise("backup", str(file), "--data", str(self.folder / "web0" / "data"))
        if result.returncode or not file.is_file():
            raise DutyError(f"backup: {result.returncode}: {result.stderr[-300:]}")
        file.unlink()


def require(answer: httpx.Response, status: int) -> httpx.Response:
    """Return the answer. Raises DutyError for another status."""
    if answer.status_code != status:
        raise DutyError(f"{answer.request.method} {answer.request.url.path}: {answer.status_code}: {answer.text[:200]}")
    return answer


DUTIES: Mapping[str, Callable[[Duties], None]] = {
    "pages read": Duties.read_pages,
    "files downloaded": Duties.download_files,
    "test sat": Duties.sit_test,
    "regrade applied and undone": Duties.regrade,
    "backup made and checked": Duties.back_up,
}
