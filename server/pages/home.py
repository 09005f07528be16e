"""The home page: a card for each module, with what to do next there."""

from __future__ import annotations

from server.course import Module
from server.gradebook import service as gradebook
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.pages.schemas import HomePage, ModuleCard, NextStep
from server.web import deadlines, editions
from server.web.views import (
    Reader,
    exercise_row,
    exercises_in_reading_order,
    lesson_href,
    lessons_in_reading_order,
    module_link,
    next_exercise,
)


def home_page(reader: Reader) -> HomePage:
    progress = gradebook.load_progress(reader.db, reader.account)
    due = deadlines.due_soon(reader.db, reader.account, progress)
    return HomePage(tuple(_card(module, progress) for module in editions.visible_editions(reader, progress)), due)


def _card(module: Module, progress: dict[str, ExerciseProgress]) -> ModuleCard:
    rows = [
        exercise_row(exercise, progress.get(exercise.id, NOTHING_YET))
        for exercise in exercises_in_reading_order(module)
    ]
    begun, row, way = any(row.own.attempts for row in rows), next_exercise(rows), lessons_in_reading_order(module)
    step = None
    if row is not None:
        step = NextStep(row.href, "Reprendre" if row.own.attempts else "Exercice suivant", row.title)
    elif way and not begun:
        step = NextStep(lesson_href(way[0]), "Commencer", way[0].label)
    return ModuleCard(module_link(module, progress), begun, step)
