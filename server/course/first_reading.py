"""Texts are rendered once, at their first reading, and never by a thread that serves pages: formulas take seconds."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Annotated

from fastapi import Depends

from server.base.app_services import app_service
from server.base.concurrency import SingleFlight
from server.base.turns import out_of_turn
from server.course.dependencies import CourseOf
from server.text.markup import MarkdownText

SingleFlightOf = Annotated[SingleFlight, Depends(app_service(SingleFlight))]


async def render_unread_texts(once: SingleFlight, texts: Iterable[MarkdownText]) -> None:
    """Render those of the texts that nobody has read yet."""
    missing = [text for text in texts if not text.is_rendered]
    if missing:
        async with out_of_turn():
            await once.run(missing[0], lambda: [text.rendered for text in missing])


async def render_lesson_of_address(course: CourseOf, once: SingleFlightOf, module: str, slug: str) -> None:
    """Render the lesson of the address, if there is one."""
    if module in course.modules:
        await render_unread_texts(
            once, [lesson.text for lesson in course.modules[module].lessons if lesson.slug == slug]
        )


async def render_exercise_of_address(course: CourseOf, once: SingleFlightOf, module: str, slug: str) -> None:
    """Render the statement and the hints of the address's exercise, if there is one."""
    exercise = course.exercises.get(f"{module}/{slug}")
    if exercise is not None:
        await render_unread_texts(once, (exercise.statement, *exercise.hint_texts))


async def render_glossary_of_address(course: CourseOf, once: SingleFlightOf, module: str) -> None:
    """Render the definitions of the address's module, if there is one."""
    if module in course.modules:
        await render_unread_texts(once, [term.definition for term in course.modules[module].glossary.values()])
