"""What no page of a class sends, and somebody does."""

from __future__ import annotations

from dataclasses import replace
from threading import Event, Thread

import pytest

from server.assignments import editing
from server.assignments.models import WeightedExercise
from server.base.errors import NotFound
from server.behaviour import service as behaviour
from server.comments import notes_repository
from server.course import Course
from server.database import Database
from server.identity import links
from server.identity.models import Role
from tests.support.classes import assign, new_class
from tests.support.service import EXERCISE, new_account

ZERO = "a\x00b"


def test_a_name_that_no_database_can_look_for_is_nobody_s(database: Database) -> None:
    """PostgreSQL refuses a zero byte in a question too."""
    made = new_class(database, new_account(database, Role.teacher))
    with database.read() as db:
        with pytest.raises(NotFound):
            behaviour.find_group(db, made, EXERCISE, ZERO)
        with pytest.raises(NotFound):
            links.find_account_by_login_or_id(db, ZERO)
        assert not notes_repository.load_student_ids_with_misconception(db, made.id, EXERCISE, ZERO)


def test_two_who_change_or_delete_an_assignment_at_once_do_so_one_after_the_other(
    database: Database, course: Course
) -> None:
    teacher = new_account(database, Role.teacher)
    made = new_class(database, teacher)
    one = assign(database, made, EXERCISE)
    there, failed = Event(), []

    def then(delete: bool) -> None:
        there.wait(300)
        try:
            with database.write() as db:
                found = editing.find_assignment(db, made, one.id, to_change=True)
                if delete:
                    return editing.delete_assignment(db, made, teacher.id, found)
                wanted = replace(editing.load_editable_fields(db, found), title="Le mien")
                editing.update_assignment(db, course, made, teacher.id, found, wanted)
        except Exception as error:
            failed.append(error)

    others = [Thread(target=then, args=(delete,)) for delete in (False, False, True, True)]
    for thread in others:
        thread.start()
    with database.write() as db:
        found = editing.find_assignment(db, made, one.id, to_change=True)
        more = (*editing.load_editable_fields(db, found).exercises, WeightedExercise("l20/kabsch"))
        editing.update_assignment(
            db, course, made, teacher.id, found, replace(editing.load_editable_fields(db, found), exercises=more)
        )
        there.set()
        for thread in others:
            thread.join(0.05)
    for thread in others:
        thread.join(300)
    assert {type(error) for error in failed} == {NotFound}, failed
