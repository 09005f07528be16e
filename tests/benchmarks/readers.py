"""A data folder for whoever measures pages: a class of 35 that has worked at 26 exercises, and who reads it.

Its verdicts are of a real one's size; those of one student's eight attempts at an exercise are real ones.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import timedelta
from pathlib import Path
from uuid import UUID

import httpx
from sqlalchemy import delete

from server.base.http import SESSION_COOKIE
from server.base.settings import Settings
from server.course import Course
from server.database import Database, utc_now
from server.database.migrate import upgrade
from server.gradebook.models import Standing
from server.identity.models import Account, ApiToken, BrowserSession, Role
from server.identity.secrets import draw_secret_token, sha256_hex
from server.submissions.models import Submission
from tests.benchmarks.bench_http import PROJECT
from tests.support.classes import assign, new_class
from tests.support.crowd import lessons, seated, store

MODULE, EXERCISE, QUIZ = "l20", "l20/poses", "l20/demo_1"
STUDENTS, EXERCISES, ATTEMPTS = 35, 26, 8
VERDICT = 4000  # characters of a verdict that no grader gave, about
WRONG = "misconceptions/*.py"


@dataclass(frozen=True)
class School:
    """Who reads, by what they show; and what stands there to read."""

    cookies: Mapping[str, Mapping[str, str]]
    token: str
    class_id: UUID
    student: UUID
    assignments: tuple[UUID, ...]
    mistake: str


def school(data: Path, course: Course) -> School:
    """Writes the database of this folder, which is not there yet."""
    database = Database(Settings(data_dir=data).sqlalchemy_url)
    upgrade(database.engine)
    with database.write() as db:
        teacher = Account(role=Role.teacher, name="Banc", login="banc@example.org")
        db.add(teacher)
    made = new_class(database, teacher, "MPSI 2")
    students = seated(database, made, STUDENTS)
    names = [one.id for one in course.modules[MODULE].exercises][:EXERCISES]
    mistakes = {name: sorted(course.exercises[name].grader.mistake_ids())[:6] for name in names}
    store(database, lessons(students, names, mistakes, utc_now()), VERDICT)
    given = tuple(
        assign(database, made, *names[start : start + 6], opened=timedelta(days=20 - start), title=f"Devoir {start}").id
        for start in range(0, EXERCISES, 6)
    )
    cookies = {"student": draw_secret_token(), "teacher": draw_secret_token()}
    token = draw_secret_token()
    with database.write() as db:
        for model in (Submission, Standing):  # the first student's attempts there are to be real ones
            db.execute(delete(model).where(model.account_id == students[0], model.exercise == EXERCISE))
        later = utc_now().replace(year=2100)
        owners = {"student": students[0], "teacher": teacher.id}
        for who, cookie in cookies.items():
            db.add(BrowserSession(token_digest=sha256_hex(cookie), account_id=owners[who], expires_at=later))
        db.add(ApiToken(account_id=students[0], label="banc", token_digest=sha256_hex(token), expires_at=later))
    database.close()
    shown = {who: {SESSION_COOKIE: cookie} for who, cookie in cookies.items()}
    return School({"visitor": {}, **shown}, token, made.id, students[0], given, mistakes[EXERCISE][0])


def attempts(address: str, made: School) -> str:
    """Has the student send wrong programs to a server of this data; the id of the last."""
    programs = [path.read_text(encoding="utf-8") for path in sorted(PROJECT.glob(f"graders/{EXERCISE}/{WRONG}"))]
    headers = {"Authorization": f"Bearer {made.token}"}
    with httpx.Client(base_url=address, headers=headers, timeout=60) as client:
        for number in range(ATTEMPTS):
            code = f"{programs[number % len(programs)]}\n# {number}\n"
            answer = client.post("/api/v1/submissions?wait=30", json={"exercise": EXERCISE, "code": code})
            assert answer.status_code == 200, answer.text
    return str(answer.json()["id"])
