"""The home page: a card for each module, with what to do next there."""

from __future__ import annotations

from collections.abc import Mapping

from server.course import Module
from server.gradebook import service as gradebook
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.hunts.service import may_ask_about_mistakes_again
from server.pages.schemas import HomePage, ModuleCard, NextStep
from server.recall import paths
from server.recall.service import OFF, REMINDERS, load_account_recall_state
from server.web import deadlines, editions
from server.web.next_step import choose_next_exercise
from server.web.views import (
    Reader,
    build_module_link,
    lesson_href,
    lessons_in_reading_order,
)


def build_home_page(reader: Reader) -> HomePage:
    progress = gradebook.load_progress(reader.db, reader.account)
    due = deadlines.load_assignments_due_soon(reader.db, reader.account, progress)
    choices = paths.load_chosen_paths(reader.db, reader.account.id if reader.account else None)
    cards = tuple(
        _build_module_card(module, progress, choices) for module in editions.choose_visible_editions(reader, progress)
    )
    solved = {name for name, own in progress.items() if own.succeeded}
    if reader.account is None or choices.get(REMINDERS) == OFF:
        return HomePage(cards, due)
    recall = load_account_recall_state(
        reader.db,
        reader.course,
        reader.account.id,
        solved,
        lambda exercise: may_ask_about_mistakes_again(reader.course, exercise),
        choices,
    )
    return HomePage(cards, due, len(recall.due), recall.streak)


def _build_module_card(module: Module, progress: dict[str, ExerciseProgress], choices: Mapping[str, str]) -> ModuleCard:
    path = paths.find_chosen_path(module, choices)
    begun = any(progress.get(exercise.id, NOTHING_YET).attempts for exercise in module.exercises)
    found, way = choose_next_exercise(module, progress, path) if begun else None, lessons_in_reading_order(module)
    step = None
    if found is not None:
        verb = "Reprendre" if found.is_begun else "Exercice suivant"
        step = NextStep(found.href, verb, found.exercise.title, found.reason)
    elif way and not begun:
        step = NextStep(lesson_href(way[0]), "Commencer", way[0].label)
    return ModuleCard(build_module_link(module, progress), begun, step)
