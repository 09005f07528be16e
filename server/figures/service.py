"""Figures of the lessons, figures and films of the verdicts: who may see which, and what is to be drawn."""

from __future__ import annotations

from dataclasses import dataclass
from uuid import UUID

from sqlalchemy.orm import Session
from starlette.concurrency import run_in_threadpool

from server.base.errors import NotFound
from server.classes import presence
from server.course.models import Course
from server.database import Database
from server.figures import drawing_requests
from server.figures.drawing_requests import DrawingRequest, Form, Theme
from server.figures.pictures import PictureRenderer
from server.gradebook import service as gradebook
from server.gradebook.figures import NO_FIGURE, NO_FILM, load_figure_data, load_film_data
from server.identity.models import Account
from server.queue.interfaces import Sender
from server.submissions.queue_senders import GUEST_RANK, MEMBER_RANK, sender_of_account


@dataclass(frozen=True)
class VerdictFigureQuery:
    """A figure of a verdict, as somebody asks for it: of the grading that counts, where none is named."""

    submission_id: str
    name: str
    form: Form
    theme: Theme
    grading: UUID | None = None


@dataclass(frozen=True)
class FigureService:
    course: Course
    database: Database
    pictures: PictureRenderer

    async def draw_lesson_figure(self, module: str, name: str, theme: Theme, address: str) -> bytes:
        """A figure of the texts, in SVG. Raises NotFound, Crowded or Failed."""
        course_module = self.course.modules.get(module)
        if course_module is None or name not in course_module.drawings:
            raise NotFound(NO_FIGURE)
        order = await run_in_threadpool(
            drawing_requests.build_lesson_figure_request, course_module.drawings[name], theme
        )
        return await self.pictures.load_or_render(order, address, MEMBER_RANK)  # there are few, and each is drawn once

    async def draw_verdict_figure(self, account: Account | None, query: VerdictFigureQuery, address: str) -> bytes:
        """A figure of a submission that this account may see. Raises NotFound, Crowded or Failed."""
        order, sender = await run_in_threadpool(self._build_verdict_figure_request, account, query, address)
        return await self.pictures.load_or_render(order, sender.flow, sender.rank)

    async def render_replay(
        self, account: Account | None, submission_id: str, check_id: str, grading: UUID | None, address: str
    ) -> bytes:
        """What the program of a submission that this account may see did in a check: JSON for the player, compressed.

        Raises NotFound, Crowded or Failed.
        """
        order, sender = await run_in_threadpool(
            self._build_replay_request, account, submission_id, check_id, grading, address
        )
        return await self.pictures.load_or_render(order, sender.flow, sender.rank)

    def _build_replay_request(
        self, account: Account | None, submission_id: str, check_id: str, grading: UUID | None, address: str
    ) -> tuple[DrawingRequest, Sender]:
        with self.database.read() as db:
            attempt = gradebook.find_attempt(db, account, submission_id)
            film, title = load_film_data(db, attempt, check_id, grading)
            sender = _turn_of_viewer(db, account, address)
        exercise = attempt.submission.exercise
        if exercise not in self.course.exercises:
            raise NotFound(NO_FILM)
        return drawing_requests.build_replay_request(exercise, film, title), sender

    def _build_verdict_figure_request(
        self, account: Account | None, query: VerdictFigureQuery, address: str
    ) -> tuple[DrawingRequest, Sender]:
        """In a transaction of its own, over before anything is drawn. Raises NotFound."""
        with self.database.read() as db:
            attempt = gradebook.find_attempt(db, account, query.submission_id)
            data = load_figure_data(db, attempt, query.name, query.grading)
            sender = _turn_of_viewer(db, account, address)
        exercise = attempt.submission.exercise
        if exercise not in self.course.exercises:
            raise NotFound(NO_FIGURE)
        return drawing_requests.build_verdict_figure_request(exercise, data, query.form, query.theme), sender


def _turn_of_viewer(db: Session, account: Account | None, address: str) -> Sender:
    """Return whose turn a figure of a verdict takes: turns are those of the queue."""
    if account is None:
        return Sender(address=address, flow=address, rank=GUEST_RANK)
    return sender_of_account(account, address, member=presence.is_active_member(db, account.id))
