"""The home page: a card for each module, with what to do next there."""

from __future__ import annotations

from server.course import Module
from server.gradebook import service as gradebook
from server.gradebook.schemas import NOTHING_YET, Progress
from server.pages.schemas import HomePage, ModuleCard, NextStep
from server.web import deadlines, editions
from server.web.views import Reader, exercise_row, in_order, lesson_href, module_link, on_the_way, resumed


def home_page(reader: Reader) -> HomePage:
    progress = gradebook.load_progress(reader.db, reader.account)
    due = deadlines.soon(reader.db, reader.account, progress)
    return HomePage(tuple(_card(module, progress) for module in editions.shown(reader, progress)), due)


def _card(module: Module, progress: dict[str, Progress]) -> ModuleCard:
    rows = [exercise_row(exercise, progress.get(exercise.id, NOTHING_YET)) for exercise in in_order(module)]
    begun, row, way = any(row.own.attempts for row in rows), resumed(rows), on_the_way(module)
    step = None
    if row is not None:
        step = NextStep(row.href, "Reprendre" if row.own.attempts else "Exercice suivant", row.title)
    elif way and not begun:
        step = NextStep(lesson_href(way[0]), "Commencer", way[0].label)
    return ModuleCard(module_link(module, progress), begun, step)
