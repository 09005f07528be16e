"""What the server writes into a lesson's text: quiz questions, exercises, retrieval questions, parts for later."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from datetime import date
from functools import lru_cache
from typing import Any

from markupsafe import Markup

from server.course import Module
from server.course.lengths import duration_in_words, estimate_exercise_minutes
from server.course.models import Lesson
from server.identity.models import Account
from server.polls import service as polls
from server.recall import retrievals
from server.web.rendering import jinja_environment
from server.web.schemas import ExerciseRow

QUESTION = re.compile(r'<section class="asked" id="[^"]*" data-question="([^"]+)">')
EXERCISE = re.compile(r'<section class="to-do" id="[^"]*" data-exercise="([^"]+)">')
RETRIEVAL = re.compile(r'<section class="asked recalled" id="[^"]*" data-retrieval="([^"]+)">')
LATER = re.compile(r'<details class="block block-later" data-later="([^"]+)" open>')


def fill_lesson_text(
    module: Module,
    lesson: Lesson,
    rows: Mapping[str, ExerciseRow],
    account: Account | None,
    left: Collection[str],
    *,
    is_heard: bool,
) -> Markup:
    """Return a lesson's text for a reader; `left` names the paths whose parts for later are folded.

    `is_heard`: answers are marked there; else the page stands away from the server.
    """
    text = _insert_quiz_questions(module, lesson, heard=is_heard)
    if lesson.text.exercises:
        text = EXERCISE.sub(lambda match: match[0] + _render_exercise_card(module, rows, match[1]), text)
    if lesson.text.retrieval_questions:
        day = retrievals.today_at_school()
        text = RETRIEVAL.sub(
            lambda match: match[0] + _render_retrieval_question(module, match[1], account, day, is_heard), text
        )
    if left:
        text = LATER.sub(lambda match: match[0][: -len(" open>")] + ">" if match[1] in left else match[0], text)
    return Markup(text)


def _load_template_macros(template: str) -> Any:
    return jinja_environment().get_template(template).module


def _render_exercise_card(module: Module, rows: Mapping[str, ExerciseRow], slug: str) -> str:
    row = rows.get(slug)
    if row is None:  # of an exercise that is at fault, and not served
        return ""
    exercise = next(exercise for exercise in module.exercises if exercise.slug == slug)
    return str(
        _load_template_macros("reading/to_do.html").to_do(row, duration_in_words(estimate_exercise_minutes(exercise)))
    )


def _render_retrieval_question(module: Module, name: str, account: Account | None, day: date, is_heard: bool) -> str:
    if name not in module.retrievals:
        return ""
    asked = retrievals.draw_retrieval(module, name, account, day)
    macros = _load_template_macros("reading/recalled.html")
    return str(macros.recalled(asked) if is_heard else macros.told(asked))


@lru_cache(maxsize=512)
def _insert_quiz_questions(module: Module, lesson: Lesson, *, heard: bool) -> str:
    """Return a lesson's text with its quiz questions where they stand; `heard`: they are marked there."""
    macros = _load_template_macros("reading/asked.html")

    def written(match: re.Match[str]) -> str:
        poll = polls.polls_of_lesson(module, lesson).get(match[1])
        if poll is None:  # of an exercise that is at fault, and not served
            return match[0]
        return match[0] + str((macros.asked if heard else macros.read)(module.slug, poll))

    return QUESTION.sub(written, lesson.html)
