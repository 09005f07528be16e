"""The way on from an exercise: what comes before and after it, and what there is once it is solved."""

from __future__ import annotations

from server.course import Exercise, Module
from server.course.models import ReadingPath
from server.hunts.service import may_have_hunts
from server.pages.hunts import hunt_href
from server.pages.schemas import Onward
from server.recall import paths
from server.web.schemas import VerdictView
from server.web.views import Reader, exercise_href, exercises_in_reading_order


def way_onward(reader: Reader, exercise: Exercise, verdict: VerdictView | None) -> Onward | None:
    """Return the way on from a solved exercise; None but beside the verdict of an attempt that passes."""
    if verdict is None or verdict.tone != "good":
        return None
    module = reader.course.modules[exercise.module]
    choices = paths.load_paths(reader.db, reader.account.id if reader.account else None)
    path = paths.find_path(module, choices)
    _, following = find_neighbours(module, exercise, path)
    return Onward(following, hunt_href(exercise) if may_have_hunts(reader.course, exercise) else "")


def find_neighbours(
    module: Module, exercise: Exercise, path: ReadingPath | None = None
) -> tuple[tuple[str, str] | None, tuple[str, str] | None]:
    """Return the address and title of the exercises before and after one, on a path or in the order of reading."""
    way = exercises_in_reading_order(module)
    if path is not None and exercise.slug in path.exercises:
        way = list(paths.order_exercises(path, way))
    if exercise not in way:  # a teacher's own
        return None, None
    place = way.index(exercise)
    around = (way[place - 1] if place else None, *way[place + 1 : place + 2], None)
    before, after = ((exercise_href(neighbour), neighbour.title) if neighbour else None for neighbour in around[:2])
    return before, after
