"""The objectives of a lesson: the exercises that show each, and the mistakes that stand in its way."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass

from server.course.schemas import ObjectiveEntry


@dataclass(frozen=True)
class Objective:
    """An objective of a lesson, as an infinitive.

    `exercises` are slugs, each with the functions by which it belongs here (empty: all of it); to solve it shows the
    objective. `mistakes` are misconceptions by slug; those of an exercise named there are its only ones here.
    """

    id: str
    text: str
    short: str
    lesson: str
    exercises: Mapping[str, frozenset[str]]
    mistakes: Mapping[str, frozenset[str]]

    def does_misconception_belong(self, slug: str, misconception: str, functions: Collection[str]) -> bool:
        """Whether a misconception of an exercise, in these functions, belongs to the objective."""
        if slug in self.mistakes:
            return misconception in self.mistakes[slug]
        own = self.exercises.get(slug)
        return own is not None and (not own or not own.isdisjoint(functions))


def build_objective(entry: ObjectiveEntry, lesson: str) -> Objective:
    exercises: dict[str, set[str]] = {}
    for name in entry.exercises:
        slug, _, function = name.partition(":")
        exercises.setdefault(slug, set()).update(filter(None, (function,)))
    mistakes: dict[str, set[str]] = {}
    for name in entry.mistakes:
        slug, _, mistake = name.partition("/")
        mistakes.setdefault(slug, set()).add(mistake)
    return Objective(
        id=entry.id,
        text=entry.text,
        short=entry.short or entry.text,
        lesson=lesson,
        exercises={slug: frozenset(functions) for slug, functions in exercises.items()},
        mistakes={slug: frozenset(names) for slug, names in mistakes.items()},
    )
