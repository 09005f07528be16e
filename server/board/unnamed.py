"""Failures that no misconception names."""

from __future__ import annotations

from sqlalchemy.orm import Session

from server.board import repository
from server.board.repository import Scope
from server.board.schemas import Unnamed
from server.board.trails import Trails, unexplained


def unnamed(db: Session, scope: Scope, trails: Trails) -> tuple[Unnamed, ...]:
    """By exercise, in the order in which they were sent. Each stands alone."""
    last = sorted((trail[-1] for trail in trails.values() if unexplained(trail)), key=lambda one: one[1:3])
    known = repository.submissions(db, scope, last)
    return tuple(Unnamed(one.exercise, None, (one.account,), known[one[:3]], None) for one in last if one[:3] in known)
