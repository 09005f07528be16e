"""Failures that no misconception names."""

from __future__ import annotations

from collections.abc import Sequence
from uuid import UUID

from sqlalchemy.orm import Session

from server.behaviour import service as behaviour
from server.board import repository
from server.board.repository import Scope
from server.board.schemas import Unnamed
from server.board.trails import Trails, unexplained


def unnamed(db: Session, scope: Scope, students: Sequence[UUID], trails: Trails) -> tuple[Unnamed, ...]:
    """Groups of equal behaviour first; then those that are in none (yet), each alone, by exercise and time.

    Groups are those of now: of an archived class, each stands alone.
    """
    found = [] if scope.until else behaviour.unnamed(db, scope.class_id, students, scope.exercises)
    groups = [Unnamed(one.exercise, one.group, tuple(one.students), one.submission, one.title) for one in found]
    grouped = {(student, one.exercise) for one in groups for student in one.students}
    left = [trail[-1] for pair, trail in trails.items() if pair not in grouped and unexplained(trail)]
    ordered = sorted(left, key=lambda one: one[1:3])
    known = repository.submissions(db, scope, ordered)
    alone = [Unnamed(one.exercise, None, (one.account,), known[one[:3]], None) for one in ordered if one[:3] in known]
    return (*groups, *alone)
