"""The home page: a card for each module, with what to do next there."""

from __future__ import annotations

from collections.abc import Mapping

from server.course import Module
from server.gradebook import service as gradebook
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.hunts.service import may_have_hunts
from server.pages.schemas import HomePage, ModuleCard, NextStep
from server.recall import paths
from server.recall.service import load_recall
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
    choices = paths.load_paths(reader.db, reader.account.id if reader.account else None)
    cards = tuple(_card(module, progress, choices) for module in editions.visible_editions(reader, progress))
    solved = {name for name, own in progress.items() if own.succeeded}
    if reader.account is None or not solved:
        return HomePage(cards, due)
    recall = load_recall(
        reader.db,
        reader.course,
        reader.account.id,
        solved,
        lambda exercise: may_have_hunts(reader.course, exercise),
        choices,
    )
    return HomePage(cards, due, 0 if recall.is_off else len(recall.due), recall.streak)


def _card(module: Module, progress: dict[str, ExerciseProgress], choices: Mapping[str, str]) -> ModuleCard:
    path, exercises = paths.find_path(module, choices), exercises_in_reading_order(module)
    begun = any(progress.get(exercise.id, NOTHING_YET).attempts for exercise in exercises)
    on_path = paths.order_exercises(path, exercises)
    rows = [exercise_row(exercise, progress.get(exercise.id, NOTHING_YET)) for exercise in on_path]
    row, way = next_exercise(rows, begun=begun), lessons_in_reading_order(module)
    step = None
    if row is not None:
        reason = "" if path is None else path.title
        step = NextStep(row.href, "Reprendre" if row.own.attempts else "Exercice suivant", row.title, reason)
    elif way and not begun:
        step = NextStep(lesson_href(way[0]), "Commencer", way[0].label)
    return ModuleCard(module_link(module, progress), begun, step)
