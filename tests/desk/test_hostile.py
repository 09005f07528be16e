"""What no page of a class sends, and somebody does."""

from __future__ import annotations

import pytest

from server.base.errors import NotFound
from server.behaviour import service as behaviour
from server.comments import words_repository
from server.database import Database
from server.identity import links
from server.identity.models import Role
from tests.support.classes import new_class
from tests.support.service import EXERCISE, new_account

ZERO = "a\x00b"


def test_a_name_that_no_database_can_look_for_is_nobody_s(database: Database) -> None:
    """PostgreSQL refuses a zero byte in a question too."""
    made = new_class(database, new_account(database, Role.teacher))
    with database.read() as db:
        with pytest.raises(NotFound):
            behaviour.find(db, made, EXERCISE, ZERO)
        with pytest.raises(NotFound):
            links.by_login(db, ZERO)
        assert not words_repository.concerned(db, made.id, EXERCISE, ZERO)
