"""Classes that have worked for weeks, and whose lessons have begun."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import timedelta
from pathlib import Path
from uuid import UUID

from sqlalchemy import insert

from server.base.settings import Settings
from server.course import Course
from server.database import Database, table_of, utc_now
from server.database.migrate import upgrade
from server.identity.models import Account, BrowserSession, Role
from server.identity.secrets import draw_secret_token, sha256_hex
from server.lesson.models import LiveLesson
from tests.benchmarks.crowd.plan import MODULE
from tests.support.classes import assign, new_class
from tests.support.crowd import lessons, seated, store

TODAY = ("poses", "odometrie", "lidar", "kabsch")
EARLIER = 22  # exercises at which the classes have worked in the weeks before
VERDICT = 4000  # characters of a verdict that no grader gave, about


@dataclass
class Lesson:
    """A class whose lesson goes on. `shown`: when each number of solved exercises first came, by exercise."""

    class_id: UUID
    teacher: str
    students: Sequence[str]
    pairs: list[tuple[str, str]]
    shown: dict[str, list[tuple[int, float]]] = field(default_factory=lambda: {slug: [] for slug in TODAY})


def prepared(data: Path, course: Course, count: int, students: int) -> list[Lesson]:
    """Write the database of this folder: so many classes that have worked for weeks, and whose lessons have begun."""
    database = Database(Settings(data_dir=data).sqlalchemy_url)
    upgrade(database.engine)
    names = [one.id for one in course.modules[MODULE].exercises if one.slug not in TODAY][:EARLIER]
    mistakes = {name: sorted(course.exercises[name].grader.mistake_ids())[:6] for name in names}
    made = [_lesson(database, number, students, names, mistakes) for number in range(count)]
    database.close()
    return made


def _lesson(
    database: Database, number: int, students: int, names: Sequence[str], mistakes: Mapping[str, Sequence[str]]
) -> Lesson:
    now = utc_now()
    with database.write() as db:
        teacher = Account(role=Role.teacher, name=f"Prof {number}")
        db.add(teacher)
    made = new_class(database, teacher, f"Classe {number}")
    accounts = seated(database, made, students, now)
    store(database, lessons(accounts, names, mistakes, now - timedelta(days=1), number), VERDICT)
    today = [f"{MODULE}/{slug}" for slug in TODAY]
    assign(database, made, *names, *today, opened=timedelta(days=20), title="Devoir")
    cookies = {account: draw_secret_token() for account in (teacher.id, *accounts)}
    with database.write() as db:
        later = now.replace(year=2100)
        sessions = [
            {"token_digest": sha256_hex(cookie), "account_id": account, "expires_at": later}
            for account, cookie in cookies.items()
        ]
        db.execute(insert(table_of(BrowserSession)), sessions)
        db.add(LiveLesson(class_id=made.id, exercises=today, started_at=now - timedelta(minutes=20)))
    own = [cookies[account] for account in accounts]
    return Lesson(made.id, cookies[teacher.id], own, [(cookie, slug) for cookie in own for slug in TODAY])
