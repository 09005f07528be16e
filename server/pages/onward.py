"""The way on from an exercise: what comes before and after it, and what there is once it is solved."""

from __future__ import annotations

from collections.abc import Mapping

from server.course import Exercise, Module
from server.course.models import ReadingPath
from server.course.practice import practised_objectives
from server.gradebook import service as gradebook
from server.gradebook.schemas import NOTHING_YET, ExerciseProgress
from server.hunts.service import may_have_hunts
from server.pages.after_success import can_review_programs
from server.pages.hunts import hunt_href
from server.pages.schemas import WayOnward
from server.recall import paths
from server.web.next_step import choose_next_exercise, list_exercises_of_path
from server.web.schemas import VerdictView
from server.web.views import Reader, exercise_href


def build_way_onward(reader: Reader, exercise: Exercise, verdict: VerdictView | None) -> WayOnward | None:
    """Return the way on from a solved exercise; None but beside the verdict of an attempt that passes."""
    if verdict is None or verdict.tone != "good":
        return None
    module = reader.course.modules[exercise.module]
    progress = gradebook.load_progress(reader.db, reader.account)
    following = choose_next_exercise(module, progress, find_chosen_path(reader, module), exercise)
    challenge = find_challenge(module, exercise, progress)
    if following is not None and following.exercise is challenge:
        challenge = None
    return WayOnward(
        following=None if following is None else (following.href, following.exercise.title),
        reason="" if following is None else following.reason,
        challenge=None if challenge is None else (exercise_href(challenge), challenge.title),
        hunts=hunt_href(exercise) if may_have_hunts(reader.course, exercise) else "",
        is_reviewed=can_review_programs(exercise, reader.course.exercises.is_packaged(exercise.id)),
    )


def find_chosen_path(reader: Reader, module: Module) -> ReadingPath | None:
    """Return the path that the reader has chosen through a module."""
    choices = paths.load_chosen_paths(reader.db, reader.account.id if reader.account else None)
    return paths.find_chosen_path(module, choices)


def find_challenge(module: Module, exercise: Exercise, progress: Mapping[str, ExerciseProgress]) -> Exercise | None:
    """Return the easiest unsolved challenge of the objectives that an exercise practises, harder than it; or None."""
    by_slug = {other.slug: other for other in module.exercises}
    own = [objective for objective in practised_objectives(module) if exercise.slug in objective.exercises]
    slugs = {slug: None for objective in own for slug in objective.exercises if slug in by_slug}
    harder = [by_slug[slug] for slug in slugs if by_slug[slug].stars > exercise.stars]
    left = [other for other in harder if not progress.get(other.id, NOTHING_YET).succeeded]
    return min(left, key=lambda other: other.stars, default=None)


def find_neighbouring_exercises(
    module: Module, exercise: Exercise, path: ReadingPath | None = None
) -> tuple[tuple[str, str] | None, tuple[str, str] | None]:
    """Return the address and title of the exercises before and after one, on a path or in the order of reading."""
    way = list_exercises_of_path(module, path if path is not None and exercise.slug in path.exercises else None)
    if exercise not in way:  # a teacher's own
        return None, None
    place = way.index(exercise)
    around = (way[place - 1] if place else None, *way[place + 1 : place + 2], None)
    before, after = ((exercise_href(neighbour), neighbour.title) if neighbour else None for neighbour in around[:2])
    return before, after
