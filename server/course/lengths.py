"""How long a page and an exercise take: one rule, for every length that is told. Pure.

The rule is a usual pace of study reading, not a measure of anybody: it counts the words, and adds a time for each thing
that one looks at, runs or answers. Minutes, rounded when they are written.
"""

from __future__ import annotations

from collections.abc import Collection
from functools import lru_cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from server.course.models import Exercise, Lesson

#: Words read in one minute, with a pen in hand (reading to learn: Carver, 1992).
WORDS_A_MINUTE = 150
#: Minutes for each thing that a page has besides its words.
MINUTES_OF = {
    "formulas": 0.5, "figures": 0.5, "cells": 3.0, "replays": 3.0, "manipulations": 3.0, "questions": 1.0,
}  # fmt: skip
#: Minutes of a question by its form, and of an exercise of code: at least so many, and one more a line.
MINUTES_OF_FORM = {"number": 3.0, "one": 1.5, "several": 2.0, "order": 10.0}
CODE_MINUTES = 10.0
MINUTES_PER_HOUR = 60
#: Lengths are written in steps of so many minutes, up to an hour and beyond it.
SHORT_STEP, LONG_STEP = 5, 10


def estimate_reading_minutes(lesson: Lesson, left_paths: Collection[str] = ()) -> float:
    """Return the minutes that a page takes, without the parts that the paths of the names `left_paths` leave for later.

    Of a paper, the time that its authors give for it.
    """
    if lesson.minutes and lesson.kind.timed:
        return lesson.minutes
    words, others = 0, 0.0
    for (path, what), amount in lesson.text.content_amounts.items():
        if path not in left_paths:
            words += amount if what == "words" else 0
            others += MINUTES_OF.get(what, 0.0) * amount
    return words / WORDS_A_MINUTE + others


@lru_cache(maxsize=1024)
def estimate_exercise_minutes(exercise: Exercise) -> int:
    """Estimate how long an exercise takes, to five minutes, from its length: of its solution, or of its questions.

    A rule of thumb, for one who has read the lesson: `MINUTES_OF_FORM` a question; 10 minutes and one more a line of
    code; half as long again for each star. Loads the grader of an exercise without code.
    """
    if exercise.answers is not None:
        minutes = sum(MINUTES_OF_FORM[question.form] for question in exercise.answers.paper(0).questions)
    else:
        code = [line for line in exercise.solution.splitlines() if line.strip() and not line.lstrip().startswith("#")]
        minutes = CODE_MINUTES + len(code)
    return max(5, 5 * round(minutes * (1 + exercise.stars / 2) / 5))


def duration_in_words(minutes: float) -> str:
    """Return « 45 min », « 2 h », « 1 h 30 » for a number of minutes, rounded; nothing for less than one."""
    if minutes < 1:
        return ""
    step = 1 if minutes < SHORT_STEP else SHORT_STEP if minutes < MINUTES_PER_HOUR else LONG_STEP
    hours, rest = divmod(max(1, step * round(minutes / step)), MINUTES_PER_HOUR)
    if not hours:
        return f"{rest}\u00a0min"
    return f"{hours}\u00a0h\u00a0{rest:02}" if rest else f"{hours}\u00a0h"
