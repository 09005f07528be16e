"""Every page of a class, of the demonstration's class as it is loaded: axe in both themes, and a phone's width."""

from __future__ import annotations

import re
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass, replace
from datetime import timedelta
from pathlib import Path
from uuid import UUID
from zlib import crc32

import pytest
from sqlalchemy import select
from sqlalchemy.orm import Session

from graders.core.code.stored_answers import serialize_answers
from graders.core.contract.findings import Judgement
from graders.core.contract.verdict import Diagnosis
from server.assignments.models import AssignedExercise, Assignment, Mode
from server.base.settings import Settings
from server.behaviour.models import BehaviourGroup, Fingerprint
from server.classes import repository as classes
from server.classes.models import ClassRole
from server.database import Database, utc_now
from server.demo.loading import DemoClass, create_demo_class
from server.gradebook.models import Grading
from server.identity.models import Account
from server.lesson.models import LiveLesson
from server.marks.models import ManualColumn, Rubric
from server.marks.rubrics import anonymous_copy_key
from server.recall.retrievals import today_at_school
from server.regrades.models import Regrade
from server.submissions.models import Submission
from server.warmup import repository as warm_ups
from server.warmup.schemas import WarmUpOption, WarmUpQuestion
from tests.contract.browser.conftest import NewVisit, enters
from tests.contract.browser.test_accessibility import check
from tests.contract.rights.test_routes import expected
from tests.support.quick import migrated, the_course
from tests.support.served import Server, serving
from tests.support.service import fake_verdict
from tests.support.shared import shared

EXERCISE, MISTAKE, GROUP = "l20/poses", "ordre_echange", "a1b2c3d4e5"
CLASS = "/classes/{class_id}"
ONE = CLASS + "/devoirs/{aid}"
#: What a browser saves, or listens to: no page.
NOT_PAGES = {
    CLASS + "/carnet/copies",
    CLASS + "/carnet/fichier",
    CLASS + "/erreurs/fichier",
    CLASS + "/evenements",
    CLASS + "/groupes/{module}/{slug}/{group}/erreur.zip",
    CLASS + "/journal/fichier",
    CLASS + "/pour-commencer/evenements",
    CLASS + "/recalculs/{regrade_id}/evenements",
    CLASS + "/seance/evenements",
    ONE + "/amenagements.csv",
}
#: Each kind of page, and the queries that make it another one.
STAFF: dict[str, tuple[str, ...]] = {
    "/classes": ("",),
    CLASS: ("",),
    CLASS + "/carnet": ("", "?devoir={aid}", "?colonne=moyenne"),
    CLASS + "/carnet/colonnes": ("",),
    CLASS + "/carnet/colonnes/{column_id}": ("",),
    CLASS + "/carnet/{student}": ("",),
    CLASS + "/carnet/{student}/{assignment_id}": ("",),
    CLASS + "/code": ("",),
    CLASS + "/conseil": ("",),
    CLASS + "/devoirs": ("",),
    CLASS + "/devoirs/nouveau": ("", "?groupe=TP1&exercice=" + EXERCISE),
    ONE: ("",),
    ONE + "/amenagements": ("",),
    ONE + "/bareme": ("",),
    ONE + "/copies/{student}": ("",),
    ONE + "/equipes": ("",),
    ONE + "/modifier": ("",),
    ONE + "/noter": ("",),
    ONE + "/noter/{copy}": ("",),
    ONE + "/pourquoi": ("?eleve={student}",),
    CLASS + "/devoirs/{assignment_id}/ressemblances": ("", "?exercice=" + EXERCISE),
    CLASS + "/eleves": ("",),
    CLASS + "/eleves/{student}": ("",),
    CLASS + "/eleves/{student}/comme": ("",),
    CLASS + "/eleves/{student}/effacer": ("",),
    CLASS + "/eleves/{student}/objectifs": ("",),
    CLASS + "/eleves/{student}/{module}/{slug}": ("",),
    CLASS + "/erreurs/{module}/{slug}/{mistake}": ("",),
    CLASS + "/erreurs/{module}/{slug}/{mistake}/projeter": ("", "?choix=oui"),
    CLASS + "/groupes": ("",),
    CLASS + "/groupes/{module}/{slug}/{group}": ("",),
    CLASS + "/journal": ("",),
    CLASS + "/liste": ("",),
    CLASS + "/mots": ("", "?exercice=" + EXERCISE),
    CLASS + "/objectifs": ("",),
    CLASS + "/previsions": ("",),
    CLASS + "/pour-commencer": ("", "?utile=oui"),
    CLASS + "/pour-commencer/projeter": ("", "?reponses=oui"),
    CLASS + "/questions": ("", "?etat=toutes"),
    CLASS + "/recalculs": ("",),
    CLASS + "/recalculs/{regrade_id}": ("",),
    CLASS + "/plateforme": ("",),
    CLASS + "/reglages": ("",),
    CLASS + "/reprise": ("?eleve={student}&exercice=" + EXERCISE,),
    CLASS + "/seance": ("",),
    CLASS + "/seance/projeter": ("",),
    CLASS + "/seance/{lesson_id}": ("",),
    CLASS + "/semaine": ("",),
    CLASS + "/tableau": ("", "?tri=bloques", "?groupe=TP1"),
}
STUDENT: dict[str, tuple[str, ...]] = {
    "/classes": ("",),
    CLASS: ("",),
    CLASS + "/objectifs": ("",),
    CLASS + "/pour-commencer": ("",),
    ONE + "/copie": ("",),
    ONE + "/mon-equipe": ("",),
    ONE + "/pourquoi": ("",),
    CLASS + "/devoirs/{assignment_id}/composer": ("",),
}


def test_each_page_of_a_class_is_walked() -> None:
    pages = {name.removeprefix("GET ") for name in expected() if re.match(r"GET /classes\b", name)}
    assert set(STAFF) | set(STUDENT) == pages - NOT_PAGES
    assert pages >= NOT_PAGES


@dataclass(frozen=True)
class Walk:
    """The demonstration's class, on the server of all browser tests."""

    server: Server
    database: Database
    teacher: Account
    student: Account
    values: dict[str, str]

    def paths(self, pages: dict[str, tuple[str, ...]]) -> Iterator[str]:
        for page, queries in pages.items():
            values = self.values
            if page.endswith("/composer"):
                values = {**values, "assignment_id": values["test"]}
            yield from ((page + query).format(**values) for query in queries)


def grade(exercise: str, source: bytes, seed: int) -> Judgement:
    """Half of what is sent is wrong; at one exercise that has a name, but for a few."""
    kind = crc32(source) % 8
    verdict = fake_verdict("# outcome: wrong_answer" if kind < 4 else "", seed)
    named = exercise == EXERCISE and 0 < kind < 4
    diagnosis = Diagnosis(MISTAKE, "Une erreur connue", "Voici pourquoi.") if named else None
    return Judgement(replace(verdict, exercise=exercise, diagnosis=diagnosis))


@pytest.fixture(scope="module")
def walk(tmp_path_factory: pytest.TempPathFactory, server: Server) -> Iterator[Walk]:
    @contextmanager
    def start(_folder: Path) -> Iterator[str]:
        yield str(_load_demo(Path(server.data), students=8))

    with shared(tmp_path_factory, "balise-walk", start) as class_id:
        database = server.open_database()
        yield _found(server, database, UUID(class_id))
        database.close()


def _load_demo(data: Path, students: int) -> UUID:
    """Load the demonstration's class, in a thread: that of a browser's test runs an event loop."""

    def load() -> UUID:
        settings = Settings(data_dir=data)
        database, course = Database(settings.sqlalchemy_url), the_course()
        module = course.modules["l20"]
        loaded = create_demo_class(
            database,
            course,
            module,
            grade,
            settings,
            seed=3,
            students=students,
            report_progress=lambda _done, _all: None,
        )
        _one_of_each(database, loaded)
        database.close()
        return loaded.class_id

    with ThreadPoolExecutor(1) as thread:
        return thread.submit(load).result()


def _one_of_each(database: Database, loaded: DemoClass) -> None:
    """Add what workers and the teacher would make later: a group of behaviour, a regrade, a rubric, a warm-up."""
    with database.write() as db:
        column = ManualColumn(class_id=loaded.class_id, title="À la main", out_of=4.0, weight=1.0, position=9)
        db.add(column)
        db.flush()
        levels = [{"points": 4.0, "text": "tout est nommé"}, {"points": 0.0, "text": "illisible"}]
        item = {"id": "a", "title": "Clarté", "points": 4.0, "levels": levels}
        home = _home(db, loaded.class_id)
        home.team_size, home.teams_by_students = 2, True
        db.add(Rubric(column_id=column.id, assignment_id=home.id, items=[item], anonymous=True, version=1))
        sent = select(Grading.id).join(Submission, Submission.grading_id == Grading.id)
        own = Submission.account_id.in_(member.id for member in classes.load_members(db, loaded.class_id))
        graded = db.scalars(sent.where(Submission.exercise == EXERCISE, own).order_by(Submission.created_at)).first()
        values = {
            "exercise_version": "v1",
            "structure": "",
            "projection": 0.0,
            "answers": serialize_answers(()),
            "functions": [],
        }
        db.add(BehaviourGroup(id=GROUP, exercise=EXERCISE, example=None, **values))
        db.add(Regrade(class_id=loaded.class_id, exercise=EXERCISE, policy="replace"))
        begun = utc_now() - timedelta(hours=1)
        db.add(LiveLesson(class_id=loaded.class_id, exercises=[EXERCISE], started_at=begun, ended_at=utc_now()))
        options = (WarmUpOption("A", "`a + b`", MISTAKE, "Voici pourquoi."), WarmUpOption("B", "`b + a`"))
        question = WarmUpQuestion("s", EXERCISE, MISTAKE, "Poses", "/", "Que vaut `f(1)` ?", options, "B", needed=5)
        warm_ups.add_warm_up_if_absent(db, loaded.class_id, today_at_school(), [question.to_data()])
        db.flush()
        db.add(Fingerprint(grading_id=graded, group_id=GROUP))


def _home(db: Session, class_id: UUID) -> Assignment:
    """Return the assignment that asks the exercise of this walk."""
    homes = select(AssignedExercise.assignment_id).where(AssignedExercise.exercise == EXERCISE)
    given = select(Assignment).where(Assignment.class_id == class_id, Assignment.mode != Mode.test)
    return db.scalars(given.where(Assignment.id.in_(homes))).one()


def _found(server: Server, database: Database, class_id: UUID) -> Walk:
    with database.read() as db:
        people = classes.load_members(db, class_id)
        given = db.scalars(select(Assignment).where(Assignment.class_id == class_id)).all()
        home = _home(db, class_id)
        rubric = db.scalars(select(Rubric).where(Rubric.assignment_id == home.id)).one()
        test = max((one for one in given if one.mode == Mode.test), key=lambda one: one.opens_at)
        ids = [member.id for member in people]
        sent = select(Submission.account_id).where(Submission.exercise == EXERCISE, Submission.account_id.in_(ids))
        at_work = db.scalars(sent).first()
        student = db.get_one(Account, at_work)
        teacher = db.get_one(Account, next(one.id for one in people if one.membership.role == ClassRole.teacher))
        held = select(LiveLesson.id).where(LiveLesson.class_id == class_id)
        columns = select(ManualColumn.id).where(ManualColumn.class_id == class_id)
        values = {
            "class_id": class_id,
            "aid": home.id,
            "assignment_id": home.id,
            "test": test.id,
            "student": student.id,
            "copy": anonymous_copy_key(rubric, student.id),
            "module": EXERCISE.split("/", maxsplit=1)[0],
            "slug": EXERCISE.split("/")[1],
            "mistake": MISTAKE,
            "group": GROUP,
            "regrade_id": db.scalars(select(Regrade.id).where(Regrade.class_id == class_id)).one(),
            "lesson_id": db.scalars(held.where(LiveLesson.ended_at.is_not(None))).first(),
            "column_id": db.scalars(columns.where(ManualColumn.id != rubric.column_id)).one(),
        }
    return Walk(server, database, teacher, student, {name: str(value) for name, value in values.items()})


#: How long a page of a class may be, whatever its number of students: in pixels.
MAX_HEIGHT = 3000
STUDENTS = 300
SCREENS = ((390, 844), (1024, 768), (1280, 800))
#: A student's own work, and what it is marked by.
LONG = {
    ONE + "/copies/{student}",
    ONE + "/noter/{copy}",
    CLASS + "/eleves/{student}",
    CLASS + "/eleves/{student}/comme",
    CLASS + "/eleves/{student}/{module}/{slug}",
}


@pytest.mark.slow
def test_no_page_of_a_class_of_300_is_longer_than_3000_pixels(
    visit: NewVisit, tmp_path_factory: pytest.TempPathFactory
) -> None:
    data = tmp_path_factory.mktemp("crowd")
    migrated(Settings(data_dir=data)).close()
    class_id = _load_demo(data, STUDENTS)
    with serving(data) as server:
        database = server.open_database()
        walk = _found(server, database, class_id)
        # Copies of 300 are too many to compare, and the server ends while a page still follows its class.
        visitor = visit(at=server, timezone_id="Europe/Paris", expected="status of 422|ERR_CONNECTION_REFUSED")
        enters(visitor, database, walk.teacher)
        heights = {}
        for path in walk.paths({page: queries for page, queries in STAFF.items() if page not in LONG}):
            visitor.page.goto(server.address + path)
            for width, height in SCREENS:
                visitor.page.set_viewport_size({"width": width, "height": height})
                heights[path, width] = visitor.page.evaluate("document.documentElement.scrollHeight")
        database.close()
    assert not {place: height for place, height in heights.items() if height > MAX_HEIGHT}


@pytest.mark.slow
@pytest.mark.parametrize("who", ["teacher", "student"])
def test_axe_finds_nothing_and_nothing_is_wider_than_a_phone(visit: NewVisit, walk: Walk, who: str) -> None:
    visitor = visit(at=walk.server)
    enters(visitor, walk.database, walk.teacher if who == "teacher" else walk.student)
    for path in walk.paths(STAFF if who == "teacher" else STUDENT):
        visitor.page.set_viewport_size({"width": 1280, "height": 800})
        answer = visitor.page.goto(walk.server.address + path)
        assert answer is not None, path
        assert answer.status == 200, path
        check(visitor, f"{who}: {path}")
        visitor.page.set_viewport_size({"width": 390, "height": 844})
        assert visitor.page.evaluate("document.documentElement.scrollWidth") == 390, path


def test_a_page_on_paper_has_the_schools_dates_alone(visit: NewVisit, walk: Walk) -> None:
    visitor = visit(at=walk.server, timezone_id="Asia/Tokyo")
    enters(visitor, walk.database, walk.teacher)
    path = CLASS + "/eleves/{student}/{module}/{slug}"
    page = visitor.open(path.format(**walk.values))
    beside = page.get_by_text("chez vous").first
    beside.wait_for()
    page.emulate_media(media="print")
    assert not beside.is_visible()
    assert page.locator("time").first.is_visible()


def test_the_sheet_of_a_class_of_35_is_printed_on_two_pages(visit: NewVisit, walk: Walk) -> None:
    visitor = visit(at=walk.server)
    enters(visitor, walk.database, walk.teacher)
    page = visitor.open((CLASS + "/conseil").format(**walk.values))
    page.evaluate(
        "body => { const rows = [...body.rows]; for (let n = rows.length; n < 35; n++)"
        " body.append(rows[n % rows.length].cloneNode(true)); }",
        page.locator(".council-sheet tbody").element_handle(),
    )
    assert len(re.findall(rb"/Type\s*/Page\b", page.pdf(prefer_css_page_size=True))) == 2
