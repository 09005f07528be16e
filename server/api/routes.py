"""The HTTP interface, version 1."""

from fastapi import APIRouter
from starlette.routing import Match
from starlette.types import Scope

from server.api import (
    assignments,
    board,
    classes,
    columns,
    comments,
    exercises,
    marks,
    me,
    names,
    regrades,
    submissions,
)


class PrefixedApiRouter(APIRouter):
    """Asked before the pages, it says by its prefix alone what is not its own: neither waits for the other."""

    def matches(self, scope: Scope) -> tuple[Match, Scope]:
        return super().matches(scope) if scope["path"].startswith(self.prefix) else (Match.NONE, {})


router = PrefixedApiRouter(prefix="/api/v1")
router.include_router(exercises.router)
router.include_router(submissions.router)
router.include_router(comments.router)
router.include_router(me.router)
router.include_router(classes.router)
router.include_router(marks.router)
router.include_router(columns.router)
router.include_router(regrades.router)
router.include_router(names.router)
router.include_router(board.router)
router.include_router(assignments.router)
