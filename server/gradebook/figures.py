"""Figures of a verdict, drawn when they are looked at, from the data stored with it."""

from collections import OrderedDict
from threading import Lock
from typing import Any, Literal
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import NotFound
from server.course.models import Course
from server.gradebook import repository
from server.gradebook.schemas import Attempt

Format = Literal["svg", "png"]
Theme = Literal["light", "dark"]
MEDIA_TYPES = {"svg": "image/svg+xml", "png": "image/png"}
NO_FIGURE = "Cette figure n’existe pas."


def figure_data(db: Session, attempt: Attempt, name: str) -> dict[str, Any]:
    """The stored data of a figure of this attempt's verdict; raises NotFound."""
    data = None if attempt.grading is None else repository.figures_of(db, attempt.grading.id).get(name)
    if not isinstance(data, dict):
        raise NotFound(NO_FIGURE)
    return data


class Figures:
    """Draws and remembers the latest drawings. Matplotlib is not thread-safe: one drawing at a time."""

    def __init__(self, course: Course, capacity: int = 256) -> None:
        self._course = course
        self._capacity = capacity
        self._drawn: OrderedDict[tuple[UUID, str, str, str], bytes] = OrderedDict()
        self._lock = Lock()

    def draw(self, db: Session, attempt: Attempt, name: str, form: Format, theme: Theme) -> bytes:
        """The picture's bytes. Slow (tens of ms) at first: call it in a thread. Raises NotFound."""
        key = (attempt.submission.grading_id or attempt.submission.id, name, form, theme)
        with self._lock:
            if key in self._drawn:
                self._drawn.move_to_end(key)
                return self._drawn[key]
        data = figure_data(db, attempt, name)
        with self._lock:
            return self._remember(key, self._render(attempt.submission.exercise, data, form, theme))

    def _render(self, exercise: str, data: dict[str, Any], form: Format, theme: Theme) -> bytes:
        known = self._course.exercises.get(exercise)
        if known is None:
            raise NotFound(NO_FIGURE)
        return known.grader.draw(data, theme=theme, extension=form)

    def _remember(self, key: tuple[UUID, str, str, str], picture: bytes) -> bytes:
        self._drawn[key] = picture
        while len(self._drawn) > self._capacity:
            self._drawn.popitem(last=False)
        return picture
