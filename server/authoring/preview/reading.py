"""Loading the course of a preview."""

from __future__ import annotations

import traceback
from pathlib import Path
from types import MappingProxyType

from graders.courses import CURRICULUM, GRADERS
from graders.discovery import discover
from server.course import Course, Problem, load_course
from server.course.start_cache import StartCache


def read_course_with_faults(place: Path, memory: StartCache | None = None, *, render: bool = False) -> Course:
    """Imports it, and looks at its texts; code that stops Python while it is imported is a fault like another."""
    try:
        found = discover(rooms=[place / GRADERS])
        return load_course(place / CURRICULUM, discovery=found, render=render, check=True, memory=memory)
    except BaseException as error:
        if isinstance(error, KeyboardInterrupt):
            raise
        last = traceback.extract_tb(error.__traceback__)[-1]
        problem = Problem(Path(last.filename), last.lineno, f"{type(error).__name__}: {error}")
        return Course(MappingProxyType({}), (problem,))
