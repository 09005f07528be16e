"""The path through a module that a reader chose, and the exercises in its order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from uuid import UUID

from sqlalchemy.orm import Session

from server.base.errors import Invalid
from server.course import Exercise, Module
from server.course.models import ReadingPath
from server.recall import repository

UNKNOWN_PATH = "Ce chemin n’existe pas, ou plus : choisissez-en un sur la page du module."


def save_chosen_path(db: Session, account_id: UUID, module: Module, page: str) -> None:
    """Store the path that an account chose, by its page; empty: none. Raise Invalid for one that does not exist."""
    if page and page not in {path.page for path in module.paths}:
        raise Invalid(UNKNOWN_PATH)
    repository.save_choice(db, account_id, f"path:{module.slug}", page)


def load_chosen_paths(db: Session, account_id: UUID | None) -> Mapping[str, str]:
    """Load the pages of the chosen paths, by the names under which they are stored."""
    return {} if account_id is None else repository.load_choices(db, account_id)


def find_chosen_path(module: Module, choices: Mapping[str, str]) -> ReadingPath | None:
    """Return the chosen path of a module, None where there is none or it has left the course."""
    page = choices.get(f"path:{module.slug}", "")
    return next((path for path in module.paths if path.page == page and path.exercises), None)


def order_exercises_by_path(path: ReadingPath | None, exercises: Sequence[Exercise]) -> Sequence[Exercise]:
    """Return the exercises of a path in its order; all of them, in theirs, without a path."""
    if path is None:
        return exercises
    by_slug = {exercise.slug: exercise for exercise in exercises}
    return [by_slug[slug] for slug in path.exercises if slug in by_slug]
