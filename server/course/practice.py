"""The objectives of a module that its exercises practise."""

from __future__ import annotations

from server.course.kinds import KINDS
from server.course.models import Module
from server.course.objectives import Objective


def practised_objectives(module: Module) -> tuple[Objective, ...]:
    """Return the objectives of the lessons of a module that exercises practise, in reading order."""
    lessons = sorted(module.lessons, key=lambda lesson: KINDS.index(lesson.kind))
    return tuple(objective for lesson in lessons for objective in lesson.skills if objective.exercises)
