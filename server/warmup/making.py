"""Questions from what a class is to see again: a call whose right answer stands among those of known mistakes, or a
question of a lesson with fresh numbers. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from graders.core.answers.retrieval import make_seed
from server.board.catalogue import find_misconception
from server.course import Course, Module
from server.course.retrievals import draw_question
from server.hunts.protocol import AnswerComparison
from server.warmup.needs import SubjectReviewNeed
from server.warmup.schemas import WarmUpOption, WarmUpQuestion
from server.web.views import exercise_href

LETTERS = "ABCDE"
MAX_OPTIONS = 4
ASKED = "Que doit renvoyer `{call}` ?"


def build_comparison_question(
    course: Course, need: SubjectReviewNeed, comparison: AnswerComparison, seed: int
) -> WarmUpQuestion:
    """Ask for the right answer to a call, the options in the order of a seed."""
    exercise = course.exercises[comparison.hunt.exercise]
    options = [WarmUpOption("", comparison.right)]
    for wrong in comparison.wrong[: MAX_OPTIONS - 1]:
        known = find_misconception(course, exercise.id, wrong.misconception)
        why = known.diagnosis.explanation.split("\n\n")[0]
        options.append(WarmUpOption("", wrong.words, known.diagnosis.title, why))
    shuffled, right = _shuffle_and_letter_options(options, seed)
    return WarmUpQuestion(
        subject=need.subject, exercise=exercise.id, misconception=comparison.hunt.misconception,
        title=exercise.title, href=exercise_href(exercise), text=ASKED.format(call=comparison.call),
        options=shuffled, right=right, needed=need.students_to_review,
    )  # fmt: skip


def build_retrieval_question(module: Module, name: str, need: SubjectReviewNeed, seed: int) -> WarmUpQuestion | None:
    """Ask a question of a lesson as a choice: numbers that known mistakes lead to are options. None where two options
    read alike."""
    drawn = replace(draw_question(module, name, seed), is_choice=True)
    words = [drawn.answer_text(drawn.answer), *(drawn.answer_text(wrong.answer) for wrong in drawn.wrong)][:MAX_OPTIONS]
    if len(set(words)) < max(2, len(words)):
        return None
    whys = ["", *(wrong.why for wrong in drawn.wrong)]
    options = [WarmUpOption("", text, why=why) for text, why in zip(words, whys, strict=False)]
    page, _, question = name.partition("/")
    lesson = next((lesson for lesson in module.lessons if lesson.slug == page), None)
    shuffled, right = _shuffle_and_letter_options(options, seed)
    return WarmUpQuestion(
        subject=need.subject, exercise=f"{module.slug}/{page}", misconception=question,
        title=lesson.title if lesson is not None else module.title,
        href=f"/{module.slug}/lire/{page}#redire-{question}", text=drawn.text,
        options=shuffled, right=right, needed=need.students_to_review, why=drawn.why,
    )  # fmt: skip


def daily_subject_seed(class_id: str, day: str, subject: str) -> int:
    """Return the seed of a class, a day and a subject."""
    return make_seed("warm-up", class_id, day, subject)


def _shuffle_and_letter_options(options: Sequence[WarmUpOption], seed: int) -> tuple[tuple[WarmUpOption, ...], str]:
    """Return options with letters, in the order of a seed, and the letter of the first."""
    order = [int(place) for place in np.random.default_rng(seed).permutation(len(options))]
    shuffled = tuple(replace(options[place], id=LETTERS[rank]) for rank, place in enumerate(order))
    return shuffled, LETTERS[order.index(0)]
