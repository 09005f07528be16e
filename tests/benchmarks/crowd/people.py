"""Accounts, classes and programs, made beforehand: what they cost is no part of what is measured."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import islice
from uuid import UUID, uuid4

from sqlalchemy import insert

from server.classes.models import ClassRole, Membership, Status
from server.course import Course
from server.database import Database, table_of, utc_now
from server.identity.models import Account, BrowserSession, Role
from server.identity.secrets import draw_secret_token, hash_password, sha256_hex
from tests.benchmarks.crowd.plan import MODULE, MOST_MISTAKES, Person, Programs
from tests.support.classes import new_class

CLASS_SIZE = 35
PASSWORD = "la foule entre en cours"


def programs(course: Course, slugs: Sequence[str]) -> dict[str, Programs]:
    found = {}
    for slug in slugs:
        grader = course.exercises[f"{MODULE}/{slug}"].grader
        known = list(grader.known_submissions())
        wrong = [
            one.source_for_seed(0).decode() for one in islice((one for one in known if one.diagnosis), MOST_MISTAKES)
        ]
        found[slug] = Programs(known[0].source_for_seed(0).decode(), wrong)
    return found


def lessons(course: Course) -> list[str]:
    return [
        f"/{MODULE}/lire/{lesson.slug}" for lesson in course.modules[MODULE].lessons if lesson.kind.name == "seance"
    ]


def enrolled(database: Database, count: int, *, with_login: bool) -> tuple[list[Person], list[tuple[str, str]]]:
    """So many students, in classes of 35, and the cookie of each class's teacher with the address of its board.

    Sessions are open; `with_login`, students have a login and `PASSWORD` instead, hashed once for all.
    """
    hashed = hash_password(PASSWORD) if with_login else None
    people: list[Person] = []
    boards: list[tuple[str, str]] = []
    for start in range(0, count, CLASS_SIZE):
        teacher, cookie = _teacher(database, len(boards))
        made = new_class(database, teacher, f"Classe {len(boards) + 1}")
        boards.append((cookie, f"/classes/{made.id}"))
        size = min(CLASS_SIZE, count - start)
        people += _seated(database, made.id, start, size, hashed)
    return people, boards


def _teacher(database: Database, number: int) -> tuple[Account, str]:
    cookie = draw_secret_token()
    with database.write() as db:
        account = Account(role=Role.teacher, name=f"Prof {number}")
        db.add(account)
        db.flush()
        db.add(_session(account.id, cookie))
    return account, cookie


def _session(account_id: UUID, cookie: str) -> BrowserSession:
    return BrowserSession(
        token_digest=sha256_hex(cookie), account_id=account_id, expires_at=utc_now().replace(year=2100)
    )


def _seated(database: Database, class_id: UUID, start: int, size: int, hashed: str | None) -> list[Person]:
    people, accounts, seats = [], [], []
    with database.write() as db:
        for number in range(start, start + size):
            name = uuid4()
            login = f"eleve{number}" if hashed else None
            person = Person(login=login) if login else Person(cookie=draw_secret_token())
            values = {"role": Role.student, "name": f"Élève {number}", "login": login, "password_hash": hashed}
            accounts.append({"id": name, **values})
            seats.append({"class_id": class_id, "account_id": name, "role": ClassRole.student, "status": Status.active})
            people.append((name, person))
        db.execute(insert(table_of(Account)), accounts)
        db.execute(insert(table_of(Membership)), seats)
        db.add_all(_session(name, person.cookie) for name, person in people if person.cookie)
    return [person for _, person in people]
