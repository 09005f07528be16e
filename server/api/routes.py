"""The HTTP interface, version 1."""

from fastapi import APIRouter

from server.api import assignments, board, classes, comments, exercises, marks, me, names, regrades, submissions

router = APIRouter(prefix="/api/v1")
router.include_router(exercises.router)
router.include_router(submissions.router)
router.include_router(comments.router)
router.include_router(me.router)
router.include_router(classes.router)
router.include_router(marks.router)
router.include_router(regrades.router)
router.include_router(names.router)
router.include_router(board.router)
router.include_router(assignments.router)
