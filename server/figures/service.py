"""Figures of the lessons, figures and films of the verdicts: who may see which, and what is to be drawn."""

from __future__ import annotations

from dataclasses import dataclass
from uuid import UUID

from starlette.concurrency import run_in_threadpool

from server.base.errors import NotFound
from server.course.models import Course
from server.database import Database
from server.figures import orders
from server.figures.orders import Form, Order, Theme
from server.figures.pictures import Pictures
from server.gradebook import service as gradebook
from server.gradebook.figures import NO_FIGURE, NO_FILM, load_figure_data, load_film_data
from server.identity.models import Account


@dataclass(frozen=True)
class Wanted:
    """A figure of a verdict, as somebody asks for it: of the grading that counts, where none is named."""

    submission_id: str
    name: str
    form: Form
    theme: Theme
    grading: UUID | None = None


@dataclass(frozen=True)
class Figures:
    course: Course
    database: Database
    pictures: Pictures

    async def of_lesson(self, module: str, name: str, theme: Theme, address: str) -> bytes:
        """A figure of the texts, in SVG. Raises NotFound, Crowded or Failed."""
        course_module = self.course.modules.get(module)
        if course_module is None or name not in course_module.drawings:
            raise NotFound(NO_FIGURE)
        order = await run_in_threadpool(orders.of_lesson, course_module.drawings[name], theme)
        return await self.pictures.picture(order, address)

    async def of_verdict(self, account: Account | None, wanted: Wanted, address: str) -> bytes:
        """A figure of a submission that this account may see. Raises NotFound, Crowded or Failed."""
        order = await run_in_threadpool(self._allowed, account, wanted)
        return await self.pictures.picture(order, address)

    async def of_film(
        self, account: Account | None, submission_id: str, check: str, grading: UUID | None, address: str
    ) -> bytes:
        """What the program of a submission that this account may see did in a check: JSON for the player, compressed.

        Raises NotFound, Crowded or Failed.
        """
        order = await run_in_threadpool(self._filmed, account, submission_id, check, grading)
        return await self.pictures.picture(order, address)

    def _filmed(self, account: Account | None, submission_id: str, check: str, grading: UUID | None) -> Order:
        with self.database.read() as db:
            attempt = gradebook.find_attempt(db, account, submission_id)
            film, title = load_film_data(db, attempt, check, grading)
        exercise = attempt.submission.exercise
        if exercise not in self.course.exercises:
            raise NotFound(NO_FILM)
        return orders.of_film(exercise, film, title)

    def _allowed(self, account: Account | None, wanted: Wanted) -> Order:
        """In a transaction of its own, over before anything is drawn. Raises NotFound."""
        with self.database.read() as db:
            attempt = gradebook.find_attempt(db, account, wanted.submission_id)
            data = load_figure_data(db, attempt, wanted.name, wanted.grading)
        exercise = attempt.submission.exercise
        if exercise not in self.course.exercises:
            raise NotFound(NO_FIGURE)
        return orders.of_verdict(exercise, data, wanted.form, wanted.theme)
