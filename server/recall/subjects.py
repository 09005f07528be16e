"""Subjects: what is scheduled, a family of misconceptions or one that has none, and what may be asked about it."""

from __future__ import annotations

from collections.abc import Iterator

from server.course import Course, Exercise
from server.course.families import find_family

#: Begins the reason, in `families.toml`, of what names no mistake: nothing is asked about it.
NO_CAUSE = "constat"


def subject_of_misconception(course: Course, exercise: Exercise, misconception: str) -> str:
    """Return the family of a misconception, or its own name with its exercise."""
    family = find_family(course.families, exercise.filing, misconception)
    return f"{exercise.id}#{misconception}" if family is None else family.id


def title_of_subject(course: Course, subject: str) -> str:
    """Return the title of a family, empty for a misconception without one."""
    family = course.families.get(subject)
    return "" if family is None else family.title


def iter_misconceptions(exercise: Exercise) -> Iterator[str]:
    """Yield the misconceptions of an exercise, without those that only tell what is seen."""
    yield from exercise.filing.families
    yield from (name for name, reason in exercise.filing.apart.items() if not reason.startswith(NO_CAUSE))
