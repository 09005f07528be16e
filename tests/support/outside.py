"""A course outside this repository, taken in for one test, and forgotten after it."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from graders import courses
from graders.core.contract import local


@contextmanager
def taken_in(place: Path) -> Iterator[None]:
    """The course is found as those of `BALISE_COURSES` are; nothing of it is left afterwards."""
    places, problems = [*courses.COURSES.folders], [*courses.COURSES.problems]
    paths = {room: [*sys.modules[room].__path__] for room in courses.ROOMS if room in sys.modules}
    modules = set(sys.modules)
    try:
        courses.add_course(place)
        yield
    finally:
        courses.COURSES.folders[:], courses.COURSES.problems[:] = places, problems
        for room, path in paths.items():
            sys.modules[room].__path__ = path
        for name in set(sys.modules) - modules:
            if str(place) in str(getattr(sys.modules[name], "__file__", None)):
                del sys.modules[name]
        for cached in (local._owning_module_folder, local._import_kit_modules, local.kit_source):
            cached.cache_clear()
