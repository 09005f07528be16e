"""Load the data of a verdict's figures and films, which `server.figures` draws, and what the figures show in words."""

from typing import Any
from uuid import UUID

from sqlalchemy.orm import Session

from graders.core.contract.verdict import Verdict
from server.base.errors import NotFound
from server.course import drawings
from server.gradebook import repository
from server.gradebook.schemas import Attempt

NO_FIGURE = "Cette figure n’existe pas."
NO_FILM = "Il n’y a rien à revoir ici."


def load_figure_data(db: Session, attempt: Attempt, name: str, grading_id: UUID | None = None) -> dict[str, Any]:
    """Return the stored data of a figure of this attempt. Raise NotFound.

    `grading_id`: one of its gradings, as an open page shows what that one said, whichever counts since.
    """
    visible_id = _find_visible_grading(db, attempt, grading_id)
    data = None if visible_id is None else repository.load_figures(db, visible_id).get(name)
    if not isinstance(data, dict):
        raise NotFound(NO_FIGURE)
    return data


def describe_figures(db: Session, grading_id: UUID, verdict: Verdict) -> dict[str, str]:
    """Return what the figures of a grading's verdict show, in words, by their names; those without words left out."""
    names = [check.figure for check in verdict.checks if check.figure]
    if not names:
        return {}
    kinds = repository.load_figure_kinds(db, grading_id, names)
    described = drawings.describe_verdict_figures(verdict.exercise)
    return {name: described[kind] for name, kind in kinds.items() if kind is not None and kind in described}


def load_film_data(
    db: Session, attempt: Attempt, check: str, grading_id: UUID | None = None
) -> tuple[dict[str, Any], str]:
    """Return the film of a check of this attempt, and the title of the check. Raise NotFound."""
    visible_id = _find_visible_grading(db, attempt, grading_id)
    row = None if visible_id is None else repository.load_film(db, visible_id, check)
    if row is None or not isinstance(row[0], dict):
        raise NotFound(NO_FILM)
    film, verdict = row
    titles = {result["id"]: result["title"] for result in verdict["checks"]}
    return film, titles.get(check, check)


def _find_visible_grading(db: Session, attempt: Attempt, grading_id: UUID | None) -> UUID | None:
    """Return the grading to show: none of a withheld attempt, whichever is asked for."""
    counting = None if attempt.grading is None else attempt.grading.id
    if grading_id is None or grading_id == counting:
        return counting
    belongs = attempt.held is None and repository.is_grading_of(db, grading_id, attempt.submission.id)
    return grading_id if belongs else None
