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
#: Minutes of an exercise: to take it up, and for each function to write or question to answer.
START_MINUTES, FUNCTION_MINUTES, QUESTION_MINUTES = 5.0, 12.0, 2.0
#: A challenge takes so many times longer for each star.
STAR_FACTOR = 1.0
MINUTES_PER_HOUR = 60
#: Lengths are written in steps of so many minutes, up to an hour and beyond it.
SHORT_STEP, LONG_STEP = 5, 10


def reading_minutes(lesson: Lesson, left: Collection[str] = ()) -> float:
    """Return the minutes that a page takes, without the parts that the paths of the names `left` leave for later.

    Of a paper, the time that its authors give for it.
    """
    if lesson.minutes and lesson.kind.timed:
        return lesson.minutes
    words, others = 0, 0.0
    for (path, what), amount in lesson.text.amounts.items():
        if path not in left:
            words += amount if what == "words" else 0
            others += MINUTES_OF.get(what, 0.0) * amount
    return words / WORDS_A_MINUTE + others


@lru_cache(maxsize=1024)
def exercise_minutes(exercise: Exercise) -> float:
    """Return the minutes that an exercise takes, its statement included. Loads the grader of one without code."""
    words = sum(len(section.text.split()) for section in exercise.statement.sections)
    if exercise.answers is None:
        work = FUNCTION_MINUTES * max(1, len(exercise.functions))
    else:
        work = QUESTION_MINUTES * len(exercise.answers.checks())
    return (START_MINUTES + words / WORDS_A_MINUTE + work) * (1 + STAR_FACTOR * exercise.stars)


def length_in_words(minutes: float) -> str:
    """Return « 45 min », « 2 h », « 1 h 30 » for a number of minutes, rounded; nothing for less than one."""
    if minutes < 1:
        return ""
    step = 1 if minutes < SHORT_STEP else SHORT_STEP if minutes < MINUTES_PER_HOUR else LONG_STEP
    hours, rest = divmod(max(1, step * round(minutes / step)), MINUTES_PER_HOUR)
    if not hours:
        return f"{rest}\u00a0min"
    return f"{hours}\u00a0h\u00a0{rest:02}" if rest else f"{hours}\u00a0h"
