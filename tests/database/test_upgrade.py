"""From the landed schema to the current one: every row is kept, and every page that shows them answers."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import ExitStack, closing
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from uuid import UUID

import pytest
from sqlalchemy import func, make_url, select

from graders.core.contract.verdict import Outcome
from server.app import ApplicationServices
from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.course import Course
from server.database import Database, utc_now
from server.database.migrate import upgrade
from server.gradebook import service as gradebook
from server.gradebook import solutions, standings
from server.gradebook.models import Grading, SolutionOpening
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.gradebook.solutions import AccessReason
from server.identity.models import Account, ApiToken, Role
from server.queue.interfaces import Lease
from server.queue.models import Job
from server.submissions.models import Submission, Variant
from server.submissions.service import GRADE
from tests.support.client import TestClient
from tests.support.postgres import new_database
from tests.support.quick import standing_app
from tests.support.service import QUIET

from .landed import ANSWERS, MANY, OWNER, POSES, Landed


@dataclass(frozen=True)
class Upgraded:
    database: Database
    settings: Settings
    landed: Landed
    course: Course


def _landed(url: str) -> Landed:
    """The landed database, filled, and brought to the current schema."""
    with closing(Database(url)) as database:
        landed = Landed(database.engine)
        upgrade(database.engine)
    return landed


@pytest.fixture(scope="module")
def of_sqlite(tmp_path_factory: pytest.TempPathFactory) -> tuple[Landed, bytes]:
    path = tmp_path_factory.mktemp("landed") / "database"
    landed = _landed(f"sqlite:///{path}")
    assert list(path.parent.iterdir()) == [path], "closing a database leaves one file"
    return landed, path.read_bytes()


@pytest.fixture(scope="module")
def of_postgresql(postgres_url: str) -> Iterator[tuple[Landed, str]]:
    with new_database(postgres_url, f"balise_landed_{os.getpid()}") as url:
        yield _landed(url), str(make_url(url).database)


@pytest.fixture
def upgraded(
    request: pytest.FixtureRequest, settings: Settings, database_url: str | None, course: Course
) -> Iterator[Upgraded]:
    """A copy of the one that was brought to the current schema, which takes a quarter of a second."""
    with ExitStack() as stack:
        if database_url is None:
            landed, content = request.getfixturevalue("of_sqlite")
            mine = settings
            path = Path(str(make_url(mine.sqlalchemy_url).database))
            path.parent.mkdir(parents=True)
            path.write_bytes(content)
        else:
            landed, name = request.getfixturevalue("of_postgresql")
            own = stack.enter_context(new_database(database_url, f"{name}_copy", name))
            mine = settings.model_copy(update={"database_url": own})
        yield Upgraded(stack.enter_context(closing(Database(mine.sqlalchemy_url))), mine, landed, course)


def test_every_row_is_kept(upgraded: Upgraded) -> None:
    landed = upgraded.landed
    with upgraded.database.read() as db:
        counts = {
            table: db.execute(select(func.count()).select_from(table)).scalar_one()
            for table in (Account, Submission, Grading, Job, Variant, SolutionOpening)
        }
        seeds = set(db.execute(select(Variant.seed)).scalars())
    graded = len(landed.sent) - 2
    assert counts == {Account: 4, Submission: graded + 2, Grading: graded, Job: 2, Variant: 2, SolutionOpening: 1}
    assert graded == MANY + 6
    assert seeds == {77, 78}


def test_a_verdict_becomes_the_first_grading(upgraded: Upgraded) -> None:
    landed = upgraded.landed

    def grading(name: str) -> Grading:
        with upgraded.database.read() as db:
            found = db.get(Grading, landed.sent[name])
            assert found is not None
            submission = db.get(Submission, landed.sent[name])
            assert submission is not None
            assert submission.grading_id == found.id == found.submission_id
            assert submission.created_at < found.started_at < found.finished_at
            return found

    wrong, answers, ours = grading("wrong"), grading("answers"), grading("ours")
    assert (wrong.outcome, wrong.score, wrong.diagnosis) == ("wrong_answer", 0.5, "rotation_oubliee")
    assert (wrong.exercise_version, wrong.seed) == ("abc123", 7)
    assert (wrong.checks_ms, wrong.diagnosis_ms, wrong.total_ms) == (1.5, 0.5, 2.0)
    assert wrong.verdict["points"] == 10
    assert (answers.checks_ms, answers.diagnosis_ms, answers.total_ms, answers.diagnosis) == (None, None, 2.5, None)
    assert (ours.outcome, ours.score, ours.total_ms) == ("internal_error", None, None)


def test_what_waits_becomes_a_job_and_what_runs_keeps_its_lease(upgraded: Upgraded) -> None:
    landed, store = upgraded.landed, QUIET
    with upgraded.database.read() as db:
        jobs = {job.key: job for job in db.execute(select(Job)).scalars()}
    queued, running = (jobs[str(landed.sent[name])] for name in ("queued", "running"))
    assert (queued.kind, queued.tries, queued.lease_token, queued.started_at) == (GRADE, 1, None, None)
    assert (running.tries, running.lease_owner, running.lease_token) == (2, OWNER, landed.lease)
    lease = Lease(running.id, landed.lease, GRADE, running.key, {}, 2, utc_now())
    with upgraded.database.write() as db:
        assert store.position(db, GRADE, queued.key) == 1
        assert store.finish(db, lease)


def test_tokens_that_had_no_end_get_one(upgraded: Upgraded) -> None:
    with upgraded.database.read() as db:
        ends = list(db.execute(select(ApiToken.expires_at)).scalars())
    assert len(ends) == 4
    assert all(timedelta(days=364) < end - utc_now() < timedelta(days=366) for end in ends)


def test_what_was_open_stays_open_to_all_and_the_first_teacher_is_the_administrator(upgraded: Upgraded) -> None:
    landed = upgraded.landed
    with upgraded.database.read() as db:
        teacher = db.get_one(Account, landed.teacher)
        assert teacher.role == Role.administrator
        assert gradebook.find_attempt(db, teacher, landed.sent["wrong"]).submission.account_id == landed.ada
        for account in (None, db.get_one(Account, landed.busy)):
            assert solutions.load_solution_access(db, account, POSES).access_reason(NOTHING_YET) is AccessReason.to_all
        roles = set(db.execute(select(Account.role).where(Account.id != landed.teacher)).scalars())
    assert roles == {"student", "guest"}


def test_standings_are_those_of_the_history(upgraded: Upgraded) -> None:
    landed, database = upgraded.landed, upgraded.database
    with database.read() as db:
        ada = db.get(Account, landed.ada)
        assert gradebook.load_progress(db, ada) == {
            POSES: ExerciseProgress(1.0, 5, succeeded=True),
            ANSWERS: ExerciseProgress(0.4, 1),
        }
        kept = standings.load_account_standings(db, landed.ada)[POSES]
        assert (kept.attempts, kept.last_outcome, kept.last_diagnosis) == (3, "timeout", None)
        sent_at = db.execute(select(Submission.created_at).where(Submission.id == landed.sent["right"])).scalar_one()
        assert kept.first_success_at == sent_at
        assert standings.load_account_standings(db, landed.busy)[POSES].attempts == MANY
    assert gradebook.rebuild_all_standings(database) == (4, 0)


def pages_of(landed: Landed, names: tuple[str, ...]) -> Iterator[tuple[str, UUID]]:
    for name in names:
        yield name, landed.sent[name]


def test_every_page_shows_what_was_there(upgraded: Upgraded) -> None:
    landed = upgraded.landed
    marks = {"wrong": "10", "right": "20", "late": "5", "answers": "8"}
    services = ApplicationServices(upgraded.settings, upgraded.course, ())
    with closing(services.database):
        services.recover_and_clean_at_start()
    app = standing_app(upgraded.settings, upgraded.course)
    with TestClient(app, cookies={SESSION_COOKIE: "Ada"}) as client:

        def page(path: str) -> str:
            answer = client.get(path)
            assert answer.status_code == 200, (path, answer.text)
            return str(answer.text)

        page("/")
        assert "Réussi" in page("/l20")
        exercise, attempts = page("/l20/exercices/poses"), page("/l20/exercices/poses/essais")
        for text_of_page in (exercise, attempts):
            assert all(f"{mark} / 20" in text_of_page for mark in ("10", "20", "5"))
            assert "Incident de notre côté" in text_of_page
        assert "Corrigé commenté" in exercise
        assert "8 / 20" in page(f"/{ANSWERS.replace('/', '/exercices/')}")
        for name, submission in pages_of(landed, tuple(marks)):
            for path in (f"/soumissions/{submission}", f"/soumissions/{submission}/verdict"):
                assert f'<p class="score">{marks[name]}<' in page(path), (name, path)
        assert "Sans rotation" in page(f"/soumissions/{landed.sent['wrong']}")
        for name in ("queued", "running", "ours"):
            page(f"/soumissions/{landed.sent[name]}")
        client.cookies.set(SESSION_COOKIE, "Guest")
        assert "15 / 20" in page("/l20/exercices/poses/essais")


def test_every_route_of_the_api_tells_what_was_there(upgraded: Upgraded) -> None:
    landed = upgraded.landed
    app = standing_app(upgraded.settings, upgraded.course)
    with TestClient(app, headers={"Authorization": "Bearer Ada"}) as client:
        told = {
            name: client.get(f"/api/v1/submissions/{landed.sent[name]}").json()
            for name in ("wrong", "right", "ours", "answers", "queued", "running")
        }
        assert client.get(f"/api/v1/exercises/{ANSWERS}").status_code == 200
        missing = client.get(f"/api/v1/submissions/{landed.sent['wrong']}/figures/none.svg")
        assert missing.status_code == 404
    assert {name: (row["status"], row["position"]) for name, row in told.items()} == {
        **dict.fromkeys(("wrong", "right", "ours", "answers"), ("done", None)),
        "queued": ("queued", 1),
        "running": ("running", None),
    }
    assert [told[name]["verdict"]["points"] for name in ("wrong", "right", "answers")] == [10, 20, 8]
    assert told["ours"]["verdict"]["outcome"] == Outcome.INTERNAL_ERROR
    assert told["queued"]["verdict"] is None


def test_figures_come_along(upgraded: Upgraded) -> None:
    from server.gradebook.figures import load_figure_data

    with upgraded.database.read() as db:
        ada = db.get(Account, upgraded.landed.ada)
        attempt = gradebook.find_attempt(db, ada, upgraded.landed.sent["wrong"])
        assert load_figure_data(db, attempt, "a") == {"kind": "fake", "name": "wrong"}
