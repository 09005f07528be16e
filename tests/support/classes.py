"""A class on a site: who is in it, each with the headers of an API token."""

from __future__ import annotations

from dataclasses import dataclass
from datetime import timedelta
from typing import Any
from uuid import UUID

from server.assignments.models import AssignedExercise, Assignment
from server.base.http import SESSION_COOKIE
from server.classes import service
from server.classes.models import ClassRole, Membership, SchoolClass, Status
from server.database import Database, utc_now
from server.identity import tokens
from server.identity.models import Account, BrowserSession, Role
from server.identity.secrets import draw_secret_token, sha256_hex
from tests.support.client import TestClient
from tests.support.service import Site, new_account


def new_class(database: Database, teacher: Account, name: str = "MPSI 2") -> SchoolClass:
    with database.write() as db:
        return service.create_class(db, teacher, name, "l20")


def seat(
    database: Database, made: SchoolClass, account: Account, as_: ClassRole = ClassRole.student, **values: Any
) -> Account:
    """Has the account be in the class."""
    with database.write() as db:
        row = {"status": Status.active, "left_at": None, **values}
        db.merge(Membership(class_id=made.id, account_id=account.id, role=as_, **row))
    return account


def assign(
    database: Database, made: SchoolClass, *exercises: str, opened: timedelta = timedelta(hours=1), **values: Any
) -> Assignment:
    """An assignment of the class, open since `opened`; a test where `values` say so."""
    with database.write() as db:
        row = {"title": "Interro", "opens_at": utc_now() - opened, **values}
        assignment = Assignment(class_id=made.id, **row)
        db.add(assignment)
        db.flush()
        for position, exercise in enumerate(exercises):
            db.add(AssignedExercise(assignment_id=assignment.id, exercise=exercise, position=position))
    return assignment


@dataclass(frozen=True)
class Person:
    """An account, with what it shows to the API and to the pages."""

    account: Account
    headers: dict[str, str]
    cookies: dict[str, str]

    @property
    def id(self) -> UUID:
        return self.account.id

    def browser(self, site: Site) -> TestClient:
        """This person's own, without following redirections."""
        return TestClient(site.app, cookies=self.cookies, follow_redirects=False)


def person(site: Site, role: Role = Role.student, name: str = "Ada", account: Account | None = None) -> Person:
    account = account or new_account(site.database, role, name)
    cookie = draw_secret_token()
    with site.database.write() as db:
        _, secret = tokens.create_token(db, account, "essai", site.settings)
        ends = service.utc_now().replace(year=2100)
        db.add(BrowserSession(token_digest=sha256_hex(cookie), account_id=account.id, expires_at=ends))
    return Person(account, {"Authorization": f"Bearer {secret}"}, {SESSION_COOKIE: cookie})
