"""Failures that no misconception names."""

from __future__ import annotations

from sqlalchemy.orm import Session

from server.behaviour import service as behaviour
from server.board.done import Done
from server.board.repository import Scope
from server.board.schemas import UnexplainedFailure


def unnamed(db: Session, scope: Scope, done: Done) -> tuple[UnexplainedFailure, ...]:
    """Groups of equal behaviour first; then those that are in none (yet), each alone, by exercise and time.

    Groups are those of now: of an archived class, each stands alone.
    """
    found = [] if scope.until else behaviour.list_unnamed_groups(db, scope.class_id, done.students, done.exercises)
    groups = [
        UnexplainedFailure(one.exercise, one.group, tuple(one.students), one.submission, one.title) for one in found
    ]
    grouped = {(student, one.exercise) for one in groups for student in one.students}
    alone = [
        UnexplainedFailure(one.exercise, None, (one.account,), one.submission, None)
        for one in done.unexplained
        if (one.account, one.exercise) not in grouped
    ]
    return (*groups, *alone)
